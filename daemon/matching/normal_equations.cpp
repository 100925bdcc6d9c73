// SPDX-License-Identifier: BSD-3-Clause
#include "matching/normal_equations.hpp"

#include <Eigen/Eigenvalues>

namespace slam {

ObservableStep solveObservable(const NormalEquations& equations, double lever, double min_information, int most) {
  ObservableStep result;
  const Eigen::Vector3d scale(1.0, 1.0, 1.0 / lever);  // theta -> metres at the mean distance
  const Eigen::Matrix3d S = scale.asDiagonal();
  const Eigen::Matrix3d H = S * equations.H * S;
  const Eigen::Matrix3d spurious = S * equations.spurious * S;

  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(H - spurious);  // ascending
  const double threshold = min_information * equations.weight;

  Eigen::Matrix3d kept = Eigen::Matrix3d::Zero();  // observable directions first, strongest first
  int n = 0, degenerate = 3;
  for (int i = 2; i >= 0; --i) {
    const Eigen::Vector3d v = eigen.eigenvectors().col(i);
    const bool seen = n < most && eigen.eigenvalues()[i] > threshold + v.dot(spurious * v);
    kept.col(seen ? n++ : --degenerate) = v;
  }
  result.observable = n;
  if (n == 0) return result;

  const auto U = kept.leftCols(n);
  const Eigen::Matrix3d inverse = U * (U.transpose() * H * U).inverse() * U.transpose();
  result.inverse = S * inverse * S;
  result.step = -result.inverse * equations.g;
  result.weakest = S * kept.col(n - 1);

  // Directions in (x, y, theta): a degenerate direction must stay degenerate there, so span the observable ones as its
  // complement.
  if (n == 3) return result;
  for (int i = n; i < 3; ++i) result.directions.col(i) = (S * kept.col(i)).normalized();
  if (n == 2) {
    const Eigen::Vector3d b = result.directions.col(2);
    Eigen::Vector3d u = b.unitOrthogonal();
    result.directions.col(0) = u;
    result.directions.col(1) = b.cross(u);
  } else {
    result.directions.col(0) =
        Eigen::Vector3d(result.directions.col(1)).cross(Eigen::Vector3d(result.directions.col(2))).normalized();
  }
  return result;
}

}  // namespace slam
