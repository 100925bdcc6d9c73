// SPDX-License-Identifier: BSD-3-Clause
#include "core/pose_covariance.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace slam::pose_covariance_test {
namespace {

const Pose2 kStep{3.0, -1.0, 0.7};

/// An error of a pose in its own axes moves what is fixed to it by this much, in that one's axes.
Eigen::Vector3d carriedError(const Eigen::Vector3d& error, const Pose2& T_a_b) {
  const Pose2 T_true_a = Pose2::fromVector(error);
  return between(T_a_b, T_true_a * T_a_b).vector();
}

TEST(PoseCovariance, IsCarriedAsASmallErrorIs) {
  constexpr double kSmall = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d error = kSmall * Eigen::Vector3d::Unit(i);
    const Eigen::Vector3d ahead = carriedError(error, kStep), behind = carriedError(-error, kStep);
    EXPECT_LT(((ahead - behind) / (2.0 * kSmall) - carrying(kStep).col(i)).norm(), 1e-6) << i;
  }
}

TEST(PoseCovariance, OfAHeadingBecomesOneOfThePlaceAcrossTheWay) {
  Eigen::Matrix3d heading = Eigen::Matrix3d::Zero();
  heading(2, 2) = 0.01 * 0.01;
  const Eigen::Matrix3d there = carried(heading, {5.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(there(1, 1), 0.05 * 0.05);
  EXPECT_DOUBLE_EQ(there(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(there(1, 2), 0.05 * 0.01);
}

TEST(PoseCovariance, IsTheSameAgainWhereTheWayComesBack) {
  Eigen::Matrix3d covariance;
  covariance << 4, 1, 0.3, 1, 3, -0.2, 0.3, -0.2, 0.5;
  EXPECT_LT((carried(carried(covariance, kStep), kStep.inverse()) - covariance).norm(), 1e-12);
}

TEST(PoseCovariance, TurnsWithItsAxes) {
  const Eigen::Matrix3d along_x = Eigen::Vector3d(4.0, 1.0, 0.5).asDiagonal();
  const Eigen::Matrix3d along_y = Eigen::Vector3d(1.0, 4.0, 0.5).asDiagonal();
  EXPECT_LT((rotated(along_x, 0.5 * std::numbers::pi) - along_y).norm(), 1e-12);
}

}  // namespace
}  // namespace slam::pose_covariance_test
