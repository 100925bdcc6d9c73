// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scan_assembler.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>
#include <vector>

#include "core/pose2.hpp"

namespace slam::scan_assembler_test {
namespace {

using Node = LidarNode;
constexpr Timestamp kBegin{std::chrono::seconds(100)};
constexpr Duration kSampleTime = std::chrono::microseconds(500);

Node nodeAt(double degrees, double metres, bool start = false) {
  return {.angle_q6 = static_cast<std::uint16_t>(degrees * 64.0),
          .distance_q2 = static_cast<std::uint32_t>(metres * 4000.0),
          .quality = static_cast<std::uint8_t>(metres > 0.0 ? 15 : 0),
          .start = start};
}

/// Feeds whole turns of `count` nodes and keeps the scans that come out.
struct Feeder {
  ScanAssembler assembler{{.range_min = 0.2F, .range_max = 8.0F}};
  Timestamp now = kBegin;
  std::vector<LaserScan> scans;

  void add(const Node& node) {
    if (const LaserScan* scan = assembler.add(node, now)) scans.push_back(*scan);
    now += kSampleTime;
  }
  void turn(int count, int first = 0) {
    for (int i = first; i < count; ++i) add(nodeAt(i * 360.0 / count, 1.0 + i * 0.001, i == 0));
  }
};

TEST(ScanAssembler, GivesWholeTurnsOnly) {
  Feeder feeder;
  feeder.turn(360, 200);  // the stream began in the middle of a turn
  EXPECT_TRUE(feeder.scans.empty());
  feeder.turn(360);
  EXPECT_TRUE(feeder.scans.empty()) << "the first node of the next turn finishes this one";
  feeder.turn(300);
  ASSERT_EQ(feeder.scans.size(), 1U);
  EXPECT_EQ(feeder.scans[0].size, 360);
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 2U);
  EXPECT_EQ(feeder.scans[1].size, 300);
}

TEST(ScanAssembler, TakesAnglesThatRiseCounterClockwise) {
  Feeder feeder;
  feeder.assembler = ScanAssembler({.clockwise = false});
  feeder.turn(4);
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 1U);
  EXPECT_NEAR(feeder.scans[0].beams()[1].bearing, std::numbers::pi / 2.0, 1e-3);
}

TEST(ScanAssembler, PlacesBeamsWithoutEchoInTheSenseOfTheirAngles) {
  for (const bool clockwise : {true, false}) {
    Feeder feeder;
    feeder.assembler = ScanAssembler({.clockwise = clockwise});
    feeder.turn(180);
    for (int i = 0; i < 180; ++i) {
      const bool echo = i % 10 > 2;  // those without lie 7 degrees ahead of their neighbours
      feeder.add(nodeAt(std::fmod(2.0 * i + (echo ? 0.0 : 7.0), 360.0), echo ? 1.0 : 0.0, i == 0));
    }
    feeder.turn(1);
    ASSERT_EQ(feeder.scans.size(), 2U);
    const auto beams = feeder.scans[1].beams();
    for (std::size_t i = 1; i < beams.size(); ++i) {
      const double turned = (clockwise ? -1.0 : 1.0) * wrapAngle(beams[i].bearing - beams[i - 1].bearing);
      EXPECT_NEAR(turned, 2.0 * std::numbers::pi / 180.0, 0.01) << i;
    }
  }
}

TEST(ScanAssembler, TurnsClockwiseDegreesIntoCounterClockwiseRadians) {
  Feeder feeder;
  feeder.add(nodeAt(0, 1.25, true));
  feeder.add(nodeAt(90, 2.5));
  feeder.add(nodeAt(135, 0));
  feeder.add(nodeAt(270, 7.75));
  feeder.add(nodeAt(0, 1, true));
  ASSERT_EQ(feeder.scans.size(), 1U);
  const LaserScan& scan = feeder.scans[0];
  ASSERT_EQ(scan.size, 4);
  constexpr double kPi = std::numbers::pi;
  const double bearings[] = {0.0, -kPi / 2, -kPi * 3 / 4, kPi / 2};
  const float ranges[] = {1.25F, 2.5F, 0.0F, 7.75F};
  for (std::size_t i = 0; i < 4; ++i) {
    const Beam& beam = scan.beams()[i];
    EXPECT_NEAR(std::remainder(beam.bearing - bearings[i], 2 * kPi), 0.0, 1e-5) << i;
    EXPECT_FLOAT_EQ(beam.range, ranges[i]) << i;
    EXPECT_EQ(beam.intensity > 0.0F, beam.range > 0.0F) << i;
  }
  EXPECT_EQ(scan.range_min, 0.2F);
  EXPECT_EQ(scan.range_max, 8.0F);
}

TEST(ScanAssembler, GivesEachBeamItsOwnTime) {
  Feeder feeder;
  feeder.turn(100, 60);
  feeder.turn(100);
  feeder.turn(100);
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    const LaserScan& scan = feeder.scans[n];
    EXPECT_EQ(scan.stamp, kBegin + (40 + 100 * static_cast<int>(n)) * kSampleTime);
    for (int i = 0; i < scan.size; ++i) {
      EXPECT_NEAR(scan.beams()[static_cast<std::size_t>(i)].time_offset, i * 500e-6, 1e-7);
    }
  }
}

TEST(ScanAssembler, ThinsAnOverfullTurnEvenlyAndCountsIt) {
  for (const auto& [nodes, stride] : {std::pair(LaserScan::kCapacity, 1),
                                      {LaserScan::kCapacity + 1, 2},
                                      {4500, 2},
                                      {8160, 2},
                                      {8161, 4},
                                      {20000, 8}}) {
    SCOPED_TRACE(nodes);
    Feeder feeder;
    feeder.turn(nodes);
    feeder.turn(10);
    ASSERT_EQ(feeder.scans.size(), 1U);
    const LaserScan& scan = feeder.scans[0];
    EXPECT_EQ(scan.size, (nodes + stride - 1) / stride);
    EXPECT_EQ(feeder.assembler.stride(), stride);
    EXPECT_EQ(feeder.assembler.thinned(), nodes - scan.size);
    for (int i = 0; i < scan.size; ++i) {
      ASSERT_NEAR(scan.beams()[static_cast<std::size_t>(i)].time_offset, i * stride * 500e-6, 1e-4) << "not even";
    }
    feeder.turn(1);
    ASSERT_EQ(feeder.scans.size(), 2U);
    EXPECT_EQ(feeder.scans[1].size, 10) << "the turn after it is whole again";
    EXPECT_EQ(feeder.assembler.stride(), 1);
  }
}

TEST(ScanAssembler, ForgetsTheTurnUnderWayOnReset) {
  Feeder feeder;
  feeder.turn(50);
  feeder.assembler.reset();
  feeder.turn(50, 25);
  feeder.turn(50);
  EXPECT_TRUE(feeder.scans.empty());
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 1U);
  EXPECT_EQ(feeder.scans[0].size, 50);
}

/// A turn as an A1 sends it: echoes are told at their corrected angle, nodes without echo 7 degrees ahead.
std::vector<Node> turnWithHoles(const std::vector<std::pair<int, int>>& holes) {
  std::vector<Node> nodes;
  for (int i = 0; i < 360; ++i) {
    bool hole = false;
    for (const auto& [first, last] : holes) hole = hole || (i >= first && i < last);
    nodes.push_back(nodeAt(std::fmod(i + (hole ? 7.0 : 0.0), 360.0), hole ? 0.0 : 2.0, i == 0));
  }
  return nodes;
}

TEST(ScanAssembler, PlacesBeamsWithoutEchoBetweenTheEchoesAroundThem) {
  for (const auto& holes : std::vector<std::vector<std::pair<int, int>>>{
           {{100, 101}}, {{100, 140}}, {{0, 30}}, {{330, 360}}, {{0, 5}, {90, 95}, {350, 360}}, {{20, 340}}}) {
    Feeder feeder;
    for (int turns = 0; turns < 2; ++turns) {
      for (const Node& node : turnWithHoles(holes)) feeder.add(node);
    }
    ASSERT_EQ(feeder.scans.size(), 1U);
    for (int i = 0; i < 360; ++i) {
      const Beam& beam = feeder.scans[0].beams()[static_cast<std::size_t>(i)];
      const double error = std::remainder(beam.bearing * 180.0 / std::numbers::pi + i, 360.0);
      EXPECT_NEAR(error, 0.0, 0.1) << i << " of the hole at " << holes[0].first;
    }
  }
}

TEST(ScanAssembler, LeavesATurnWithoutAnyEchoAsItIs) {
  Feeder feeder;
  for (int turns = 0; turns < 2; ++turns) {
    for (const Node& node : turnWithHoles({{0, 360}})) feeder.add(node);
  }
  ASSERT_EQ(feeder.scans.size(), 1U);
  EXPECT_EQ(feeder.scans[0].size, 360);
  EXPECT_NEAR(feeder.scans[0].beams()[0].bearing, -7.0 * std::numbers::pi / 180.0, 1e-4);
}

TEST(ScanAssembler, GivesUpATurnWhoseSuccessorsStartWasLost) {
  Feeder feeder;
  feeder.turn(360);
  feeder.turn(360);
  feeder.turn(360, 10);  // its start and some more are missing
  EXPECT_EQ(feeder.assembler.broken(), 1U);
  feeder.turn(360);
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 2U) << "the first turn, and the one behind the damage";
  for (const LaserScan& scan : feeder.scans) EXPECT_EQ(scan.size, 360);
}

TEST(ScanAssembler, HasRoomForTheDensestAndSlowestTurn) {
  EXPECT_GT(LaserScan::kCapacity, 1432) << "8000 samples/s at 5.5 turns a second";
  EXPECT_GT(LaserScan::kCapacity, 0.3 / 127e-6) << "at 0.3 s a turn";
}

TEST(ScanAssembler, HandsTheQualityOnAsIntensity) {
  Feeder feeder;
  for (const int quality : {0, 1, 15, 47, 63}) {
    Node node = nodeAt(10.0 * quality / 4.0, 2.0, quality == 0);
    node.quality = static_cast<std::uint8_t>(quality);
    feeder.add(node);
  }
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 1U);
  const float intensities[] = {0.0F, 1.0F, 15.0F, 47.0F, 63.0F};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(feeder.scans[0].beams()[i].intensity, intensities[i]);
}

TEST(ScanAssembler, LeavesBeamsWithoutEchoThatAreInOrderWhereTheyAre) {
  // As a unit tells them that corrects nothing: the holes' beams are not even, and right.
  Feeder feeder;
  const double degrees[] = {0, 40, 50, 60, 120, 200, 210, 300};
  for (int turns = 0; turns < 2; ++turns) {
    for (const double angle : degrees) {
      feeder.add(nodeAt(angle, angle == 50 || angle == 60 || angle == 210 ? 0.0 : 2.0, angle == 0));
    }
  }
  ASSERT_EQ(feeder.scans.size(), 1U);
  for (std::size_t i = 0; i < std::size(degrees); ++i) {
    const double bearing = feeder.scans[0].beams()[i].bearing * 180.0 / std::numbers::pi;
    EXPECT_NEAR(std::remainder(bearing + degrees[i], 360.0), 0.0, 1e-3) << degrees[i];
  }
}

TEST(ScanAssembler, AllowsATurnOfThirtyDegreesMoreAndNoMore) {
  for (const int more : {29, 31}) {
    Feeder feeder;
    feeder.turn(360);
    for (int i = 0; i <= more; ++i) feeder.add(nodeAt(i, 2.0));  // without a start
    EXPECT_EQ(feeder.assembler.broken(), more > 30 ? 1U : 0U) << more;
    EXPECT_EQ(feeder.assembler.turns(), more > 30 ? 2U : 1U) << more;
  }
}

}  // namespace
}  // namespace slam::scan_assembler_test
