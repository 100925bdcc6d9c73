// SPDX-License-Identifier: BSD-3-Clause
// What errors that each scan has do to a match, against matches of scans that have them.
#include "matching/systematic.hpp"

#include <gtest/gtest.h>

#include "matching/plicp.hpp"
#include "matching/scanning.hpp"

namespace slam::systematic_test {
namespace {

using test::Room;

using Errors = Eigen::Matrix<double, kSystematic, 1>;  // [m], [1]

/// Points of a scan whose ranges and bearings are off.
ScanPoints scanWith(const Errors& errors, const Room& room, const Pose2& pose) {
  std::mt19937 random(1);
  ScanPoints points = test::scanPoints(room, pose, random);
  for (ScanPoint& point : points) {
    point.beam = point.position.normalized();
    point.position += shiftOf(point) * errors;
  }
  return points;
}

/// A map of some scans, drawn at poses that the errors have moved as far as they move the first of them.
Reference mapWith(const Errors& errors, const Room& room, std::initializer_list<Pose2> poses) {
  Reference reference({.extent = 80.0});
  for (const Pose2& pose : poses) reference.add(pose, scanWith(errors, room, pose));
  return reference;
}

/// Where a scan with these errors is matched.
MatchResult matchWith(const Errors& errors, const Reference& reference, const Room& room, const Pose2& pose) {
  return matchPointToLine(reference, scanWith(errors, room, pose), pose);
}

/// How an error moves the match, by central differences. @param in_map the map was drawn with it, too
Eigen::Vector3d movedBy(Systematic error, double size, bool in_map, const Room& room,
                        std::initializer_list<Pose2> mapped, const Pose2& pose) {
  const auto at = [&](double sign) {
    const Errors errors = sign * size * Errors::Unit(error);
    return matchWith(errors, mapWith(in_map ? errors : Errors::Zero(), room, mapped), room, pose);
  };
  const MatchResult ahead = at(1.0), behind = at(-1.0);
  EXPECT_EQ(ahead.status, MatchStatus::kConverged);
  EXPECT_EQ(behind.status, MatchStatus::kConverged);
  Eigen::Vector3d moved = ahead.T_ref_base.vector() - behind.T_ref_base.vector();
  return moved / (2.0 * size);
}

Sensitivity claimed(const Reference& reference, const Room& room, const Pose2& pose) {
  const MatchResult match = matchWith(Errors::Zero(), reference, room, pose);
  return sensitivityOf(reference, scanWith(Errors::Zero(), room, pose), match, Sensitivity::Zero());
}

/// A map that no lidar has drawn.
Reference planOf(const Room& room, std::initializer_list<Pose2> poses) {
  Reference reference({.extent = 80.0});
  for (const Pose2& pose : poses) {
    ScanPoints points = scanWith(Errors::Zero(), room, pose);
    for (ScanPoint& point : points) point.beam.setZero();
    reference.add(pose, points);
  }
  return reference;
}

const Room kRoom{.length = 6.0, .width = 4.0};
const Room kHall{.length = 40.0, .width = 30.0, .reach = 12.0};
const Pose2 kCorner{-12.0, -9.0, 0.4};  // of the hall: two of its walls are in sight

TEST(Systematic, ARangeBiasCancelsBetweenWallsThatFaceEachOther) {
  const Pose2 middle{0.0, 0.0, 0.3};
  const Sensitivity sensitivity = claimed(planOf(kRoom, {middle}), kRoom, middle);
  EXPECT_LT(sensitivity.col(kRangeBias).norm(), 0.03);
}

TEST(Systematic, ARangeBiasActsFullyWhereAWallStandsOnOneSideOnly) {
  const Sensitivity sensitivity = claimed(planOf(kHall, {kCorner}), kHall, kCorner);
  // Both walls are off by most of the bias, at their nearest points by all of it; the robot goes the other way.
  EXPECT_GT(sensitivity(0, kRangeBias), 0.6);
  EXPECT_GT(sensitivity(1, kRangeBias), 0.6);
  const Eigen::Vector3d moved = movedBy(kRangeBias, 0.01, false, kHall, {kCorner}, kCorner);
  EXPECT_LT((sensitivity.col(kRangeBias) - moved).norm(), 0.15 * moved.norm());
}

TEST(Systematic, WhatTheMapWasDrawnWithMovesNothing) {
  for (const auto& [room, pose] : {std::pair(kRoom, Pose2{1.0, 0.5, 0.3}), std::pair(kHall, kCorner)}) {
    const Sensitivity sensitivity = claimed(mapWith(Errors::Zero(), room, {pose}), room, pose);
    EXPECT_LT(sensitivity.cwiseAbs().maxCoeff(), 0.03);
  }
}

TEST(Systematic, AWallSeenFromElsewhereIsBentOtherwise) {
  const Pose2 on = kCorner * Pose2{2.0, -1.0, 0.2};
  const Sensitivity sensitivity = claimed(mapWith(Errors::Zero(), kHall, {kCorner}), kHall, on);
  for (const auto& [error, size] : {std::pair(kRangeBias, 0.02), std::pair(kBearingScale, 0.001)}) {
    const Eigen::Vector3d moved = movedBy(error, size, true, kHall, {kCorner}, on);
    EXPECT_GT(moved.norm(), 0.02);
    EXPECT_LT((sensitivity.col(error) - moved).norm(), 0.25 * moved.norm())
        << "claimed " << sensitivity.col(error).transpose() << ", measured " << moved.transpose();
  }
}

TEST(Systematic, StaysAsPredictedWhereTheMatchSeesNothing) {
  const Room corridor{.length = 80.0, .width = 2.0, .reach = 8.0};
  const Reference reference = mapWith(Errors::Zero(), corridor, {Pose2{}, Pose2{0.3, 0.0, 0.0}});
  const ScanPoints points = scanWith(Errors::Zero(), corridor, {});
  const MatchResult match = matchPointToLine(reference, points, {});
  ASSERT_EQ(match.observable, 2);
  Sensitivity predicted = Sensitivity::Zero();
  predicted.col(kRangeBias) = Eigen::Vector3d(3.0, 2.0, 0.1);
  const Sensitivity sensitivity = sensitivityOf(reference, points, match, predicted);
  EXPECT_NEAR(sensitivity(0, kRangeBias), 3.0, 0.05);
  EXPECT_NEAR(sensitivity(1, kRangeBias), 0.0, 0.1) << "across, the map says where it is";
  EXPECT_NEAR(sensitivity(2, kRangeBias), 0.0, 0.01);
}

TEST(Systematic, AMapThatIsDrawnAtAMovedPoseMovesWithIt) {
  Reference reference({.extent = 80.0});
  Sensitivity of_map = Sensitivity::Zero();
  of_map.col(kRangeBias) = Eigen::Vector3d(1.0, -2.0, 0.3);
  const Pose2 pose{0.5, 0.2, 0.1};
  reference.add(pose, scanWith(Errors::Zero(), kRoom, pose), of_map);
  const Sensitivity sensitivity = claimed(reference, kRoom, pose);
  EXPECT_LT((sensitivity - of_map).cwiseAbs().maxCoeff(), 0.05);
}

}  // namespace
}  // namespace slam::systematic_test
