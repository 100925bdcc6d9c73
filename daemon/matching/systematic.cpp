// SPDX-License-Identifier: BSD-3-Clause
#include "matching/systematic.hpp"

#include <Eigen/Cholesky>

namespace slam {

Sensitivity sensitivityOf(const Reference& reference, std::span<const ScanPoint> points, const MatchResult& match,
                          const Sensitivity& predicted, const MatchConfig& config) {
  const PointTransform T(match.T_ref_base);
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity();  // as if one more point told each direction: so it is regular
  Sensitivity pulls = Sensitivity::Zero();
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d p = T * point.position, lever = T.turned(point.position);
    if (!point.hasNormal() || !reference.covers(p)) continue;
    const Surfel* surfel = reference.nearest(p, config.final_pair_distance);
    if (surfel == nullptr || !surfel->isLine()) continue;
    const Eigen::Vector2d n(surfel->nx, surfel->ny);
    if (n.dot(T.turned(point.normal)) < config.same_face) continue;
    const double e = n.dot(p - Eigen::Vector2d(surfel->x, surfel->y)) / config.kernel_scale;
    const double w = surfel->observations / (1.0 + surfel->observations) / (1.0 + e * e);
    const Eigen::Vector3d J(n.x(), n.y(), n.dot(Eigen::Vector2d(-lever.y(), lever.x())));
    Eigen::Matrix<double, 1, kSystematic> apart = n.transpose() * shiftOf(point, T, predicted);
    for (int i = 0; i < kSystematic; ++i) apart[i] -= surfel->shift[static_cast<std::size_t>(i)];
    H += w * J * J.transpose();
    pulls += w * J * apart;
  }
  const auto U = match.directions.leftCols(match.observable);
  return predicted - U * (U.transpose() * H * U).ldlt().solve(U.transpose() * pulls);
}

}  // namespace slam
