// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/scan_assembler.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace slam::rplidar {
namespace {

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

TEST(ScanAssembler, CountsTheBeamsOfAnOverfullTurn) {
  Feeder feeder;
  feeder.turn(LaserScan::kCapacity + 904);
  EXPECT_EQ(feeder.assembler.overfull(), 904U);
  feeder.turn(10);
  ASSERT_EQ(feeder.scans.size(), 1U);
  EXPECT_EQ(feeder.scans[0].size, LaserScan::kCapacity);
  feeder.turn(1);
  ASSERT_EQ(feeder.scans.size(), 2U);
  EXPECT_EQ(feeder.scans[1].size, 10) << "the turn after it is whole again";
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

}  // namespace
}  // namespace slam::rplidar
