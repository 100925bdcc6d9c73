// SPDX-License-Identifier: BSD-3-Clause
#include "matching/match_result.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>

namespace slam::match_result_test {
namespace {

MatchResult matchedAt(const Pose2& pose, int observable, double blind_bearing = 0.0) {
  MatchResult match;
  match.status = observable == 3 ? MatchStatus::kConverged : MatchStatus::kUnobservable;
  match.T_ref_base = pose;
  match.observable = observable;
  const Eigen::Vector3d blind(std::cos(blind_bearing), std::sin(blind_bearing), 0.0);
  const Eigen::Vector3d across(-blind.y(), blind.x(), 0.0);
  match.directions << across, Eigen::Vector3d::UnitZ(), blind;
  return match;
}

void expectOrthonormal(const Eigen::Matrix3d& directions) {
  EXPECT_LT((directions.transpose() * directions - Eigen::Matrix3d::Identity()).norm(), 1e-12) << directions;
}

TEST(HeldAlong, KeepsTheHeadingAndWhatLiesAcross) {
  for (const double bearing : {0.0, 0.7, 2.0, -3.0}) {
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing)), position(1.0, 2.0);
    const Eigen::Vector2d pulled = position + 0.3 * along;
    const MatchResult held = projectedOut(matchedAt({pulled.x(), pulled.y(), 0.4}, 3, 1.1), position, along);
    EXPECT_TRUE(held.usable());
    EXPECT_EQ(held.status, MatchStatus::kUnobservable);
    EXPECT_LT((held.T_ref_base.vector() - Eigen::Vector3d(1.0, 2.0, 0.4)).norm(), 1e-12);
    ASSERT_EQ(held.observable, 2);
    expectOrthonormal(held.directions);
    EXPECT_NEAR(std::abs(held.directions.col(2).head<2>().dot(along)), 1.0, 1e-12) << "blind along the pull";
  }
}

TEST(HeldAlong, ABlindMatchLosesTheDirectionThatItSaw) {
  // It saw y and the heading, and was pulled along y.
  const MatchResult held = projectedOut(matchedAt({0.0, 0.2, 0.1}, 2), {0.0, 0.0}, {0.0, 1.0});
  ASSERT_EQ(held.observable, 1);
  expectOrthonormal(held.directions);
  EXPECT_NEAR(std::abs(held.directions(2, 0)), 1.0, 1e-12) << "the heading is left";
}

TEST(HeldAlong, AMatchThatSawOneDirectionOnlyReportsNothing) {
  const MatchResult held = projectedOut(matchedAt({0.0, 0.2, 0.1}, 1), {0.0, 0.0}, {0.0, 1.0});
  EXPECT_EQ(held.observable, 0);
  EXPECT_FALSE(held.usable());
  expectOrthonormal(held.directions);
}

}  // namespace
}  // namespace slam::match_result_test
