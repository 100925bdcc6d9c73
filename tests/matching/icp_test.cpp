// SPDX-License-Identifier: BSD-3-Clause
#include "matching/icp.hpp"

#include <gtest/gtest.h>

#include "matching/plicp.hpp"
#include "matching/scanning.hpp"

namespace slam::icp_test {
namespace {

using test::Room;
using test::scanPoints;

TEST(Icp, RecoversAMotionUnderNoiseButNoBetterThanPointToLine) {
  const Room room{.range_sigma = 0.01};
  std::mt19937 random(1);
  double icp_error = 0.0, plicp_error = 0.0;
  constexpr int kTrials = 20;
  for (int trial = 0; trial < kTrials; ++trial) {
    Reference reference;
    reference.add(Pose2{}, scanPoints(room, Pose2{0.4, -0.3, 0.1}, random));
    const Pose2 motion{0.12, -0.07, 0.08};
    const auto scan = scanPoints(room, Pose2{0.4, -0.3, 0.1} * motion, random);
    const MatchResult icp = matchPointToPoint(reference, scan, {}), plicp = matchPointToLine(reference, scan, {});
    ASSERT_EQ(icp.status, MatchStatus::kConverged);
    const Pose2 a = between(motion, icp.T_ref_base), b = between(motion, plicp.T_ref_base);
    icp_error += std::hypot(a.x, a.y) / kTrials;
    plicp_error += std::hypot(b.x, b.y) / kTrials;
  }
  EXPECT_LT(icp_error, 0.05);
  EXPECT_LT(plicp_error, icp_error);
}

TEST(Icp, RefusesTooFewPairs) {
  std::mt19937 random(2);
  Reference reference;
  const auto points = scanPoints(Room{}, Pose2{}, random);
  reference.add(Pose2{}, points);
  EXPECT_EQ(matchPointToPoint(reference, points, {40.0, 0, 0}).status, MatchStatus::kTooFewPairs);
}

TEST(Icp, OfAScanWithItselfIsIdentity) {
  std::mt19937 random(3);
  Reference reference;
  const auto points = scanPoints(Room{}, Pose2{}, random);
  reference.add(Pose2{}, points);
  const MatchResult result = matchPointToPoint(reference, points, {});
  EXPECT_LT(std::hypot(result.T_ref_base.x, result.T_ref_base.y), 0.005);
}

TEST(PointToPoint, HasTheInformationOfItsPairs) {
  Reference reference;
  ScanPoints points;
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.157 * i;
    points.push_back(
        {.position = (2.0 + 0.3 * (i % 4)) * Eigen::Vector2d(std::cos(angle), std::sin(angle)), .range = 2.0});
  }
  reference.add({}, points);
  double lever = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].position.x() += i % 2 == 0 ? 0.02 : -0.02;
    lever += points[i].position.squaredNorm();
  }
  const MatchResult result = matchPointToPoint(reference, points, {});
  ASSERT_EQ(result.status, MatchStatus::kConverged);
  EXPECT_EQ(result.pairs, 40);
  EXPECT_NEAR(result.residual, 0.02, 1e-3);
  EXPECT_NEAR(result.covariance(0, 0), 0.02 * 0.02 / 40, 1e-6);
  EXPECT_NEAR(result.covariance(1, 1), 0.02 * 0.02 / 40, 1e-6);
  EXPECT_NEAR(result.covariance(2, 2), 0.02 * 0.02 / lever, 0.1 * 0.02 * 0.02 / lever);
}

}  // namespace
}  // namespace slam::icp_test
