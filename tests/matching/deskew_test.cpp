// SPDX-License-Identifier: BSD-3-Clause
#include "matching/deskew.hpp"

#include <gtest/gtest.h>

#include "support/allocations.hpp"
#include "support/simulated/room.hpp"

namespace slam::deskew_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{1000s};

/// A turn of 180 ms in a 6 m x 4 m room by a lidar ahead of the base, which moves at a constant twist.
struct Turn {
  LaserScan scan;
  PoseHistory history{64};
};

Turn turnAt(const Eigen::Vector3d& twist, const Pose2& start, const Pose2& T_base_lidar) {
  Turn turn;
  turn.scan.stamp = kStart;
  const test::Room room;
  constexpr int kBeams = 360;
  for (int i = 0; i < kBeams; ++i) {
    const double t = 0.18 * i / kBeams, bearing = wrapAngle(-2.0 * std::numbers::pi * i / kBeams);
    const Pose2 lidar = start * exp(t * twist) * T_base_lidar;
    turn.scan.push({.range = static_cast<float>(room.range(lidar, bearing)),
                    .bearing = static_cast<float>(bearing),
                    .time_offset = static_cast<float>(t)});
  }
  for (int i = 0; i <= 36; ++i) turn.history.push(kStart + i * 5ms, Pose2{5, 5, 1} * exp(0.005 * i * twist));
  return turn;
}

class DeskewTurnRate : public testing::TestWithParam<double> {};

TEST_P(DeskewTurnRate, LeavesWallsStraight) {
  const Pose2 start{0.3, -0.2, 0.2}, T_base_lidar{0.1, 0.05, 0.3};
  const Turn turn = turnAt({0.5, 0.0, GetParam()}, start, T_base_lidar);
  ScanPoints points;
  deskew(turn.scan, {0.1F, 12.0F}, kStart, T_base_lidar, turn.history, points);
  ASSERT_EQ(points.size(), 360U);
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d p = start * point.position;  // every point lies on a wall of the room
    const double distance = std::min(std::abs(std::abs(p.x()) - 3.0), std::abs(std::abs(p.y()) - 2.0));
    EXPECT_LT(distance, 0.002);
  }
}

TEST_P(DeskewTurnRate, LeavesWallsStraightUnderALidarThatHangsTopDown) {
  const Pose2 start{0.3, -0.2, 0.2}, T_base_lidar{0.1, 0.05, 0.3};
  Turn turn = turnAt({0.5, 0.0, GetParam()}, start, T_base_lidar);
  for (int i = 0; i < turn.scan.size; ++i) {
    Beam& beam = turn.scan.storage[static_cast<std::size_t>(i)];
    beam.bearing = -beam.bearing;
  }
  ScanPoints points;
  deskew(turn.scan, {0.1F, 12.0F}, kStart, {T_base_lidar, true}, turn.history, points);
  ASSERT_EQ(points.size(), 360U);
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d p = start * point.position;
    EXPECT_LT(std::min(std::abs(std::abs(p.x()) - 3.0), std::abs(std::abs(p.y()) - 2.0)), 0.002);
  }
}

INSTANTIATE_TEST_SUITE_P(From0To2RadPerSecond, DeskewTurnRate, testing::Values(0.0, 0.5, 1.0, -1.0, 2.0, -2.0));

TEST(Deskew, WithoutHistoryTakesTheRobotToStandStill) {
  const Turn turn = turnAt({0, 0, 0}, Pose2{}, Pose2{});
  ScanPoints points;
  deskew(turn.scan, {0.1F, 12.0F}, kStart, Pose2{}, PoseHistory(2), points);
  EXPECT_EQ(points.size(), 360U);
}

TEST(Deskew, LeavesOutWhatIsNoReturn) {
  LaserScan scan;
  scan.range_min = 0.15F;
  scan.range_max = 10.0F;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float range : {0.0F, 0.1F, nan, std::numeric_limits<float>::infinity(), 11.0F, 1.0F})
    scan.push({.range = range});
  scan.push({.range = 1.0F, .bearing = nan});
  ScanPoints points;
  deskew(scan, {0.15F, 10.0F}, kStart, Pose2{}, PoseHistory(2), points);
  EXPECT_EQ(points.size(), 1U);
}

TEST(Deskew, GivesTheSameBitsWithATableOfBearings) {
  Turn turn = turnAt({0.5, 0.0, 1.0}, Pose2{}, Pose2{});
  BearingTable bearings;
  for (const float moved : {0.0F, 0.0F, 0.01F, 0.0F, -3.0F}) {  // from turn to turn, the second has them all
    for (int i = 0; i < turn.scan.size; ++i) turn.scan.storage[static_cast<std::size_t>(i)].bearing += moved;
    ScanPoints with, without;
    deskew(turn.scan, {0.1F, 12.0F}, kStart, Pose2{}, turn.history, with, &bearings);
    deskew(turn.scan, {0.1F, 12.0F}, kStart, Pose2{}, turn.history, without);
    ASSERT_EQ(with.size(), without.size());
    for (std::size_t i = 0; i < with.size(); ++i) EXPECT_EQ(with[i].position, without[i].position) << moved << " " << i;
  }
}

TEST(Deskew, DoesNotAllocateOnceItsOutputHasRoom) {
  const Turn turn = turnAt({0.5, 0, 1.0}, Pose2{}, Pose2{});
  ScanPoints points;
  points.reserve(LaserScan::kCapacity);
  EXPECT_EQ(test::allocationsDuring([&] {
              deskew(turn.scan, {0.1F, 12.0F}, kStart, Pose2{}, turn.history, points);
            }),
            0U);
}

TEST(Deskew, FollowsATurnByMoreThanHalfARoundWithinOneScan) {
  for (const double rate : {20.0, -20.0}) {
    const Pose2 start{0.3, -0.2, 0.2};
    const Turn turn = turnAt({0.5, 0.0, rate}, start, {});
    ScanPoints points;
    deskew(turn.scan, {0.1F, 12.0F}, kStart, Pose2{}, turn.history, points);
    ASSERT_EQ(points.size(), 360U);
    for (const ScanPoint& point : points) {
      const Eigen::Vector2d p = start * point.position;
      EXPECT_LT(std::min(std::abs(std::abs(p.x()) - 3.0), std::abs(std::abs(p.y()) - 2.0)), 0.005);
    }
  }
}

}  // namespace
}  // namespace slam::deskew_test
