// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>

#include "core/pose2.hpp"

namespace slam::test {

/// Normalised estimation error squared, e^T P^-1 e, over many estimates [Bar-Shalom 2001, section 5.4]: on average the
/// number of degrees of freedom where P is the covariance of e.
class Consistency {
 public:
  /// @param directions columns: unit directions of (x, y, theta); the first `observable` of them were estimated
  void add(const Pose2& estimate, const Pose2& truth, const Eigen::Matrix3d& covariance,
           const Eigen::Matrix3d& directions = Eigen::Matrix3d::Identity(), int observable = 3) {
    constexpr std::array kChiSquare95{0.0, 3.841, 5.991, 7.815};
    Eigen::Vector3d error = estimate.vector() - truth.vector();
    error.z() = wrapAngle(error.z());
    const auto U = directions.leftCols(observable);
    const Eigen::VectorXd e = U.transpose() * error;
    const Eigen::MatrixXd P = U.transpose() * covariance * U;
    const double nees = e.dot(P.llt().solve(e));
    sum_ += nees;
    degrees_ += observable;
    ++count_;
    if (nees < kChiSquare95.at(static_cast<std::size_t>(observable))) ++within_;
  }

  int count() const { return count_; }
  double ratio() const { return sum_ / degrees_; }                                ///< mean NEES a degree of freedom
  double shareWithin95() const { return static_cast<double>(within_) / count_; }  ///< of the chi-square bound

 private:
  double sum_ = 0.0;
  int degrees_ = 0, count_ = 0, within_ = 0;
};

}  // namespace slam::test
