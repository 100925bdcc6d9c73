// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/stuck_scan_detector.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <random>

namespace slam {
namespace {

/// Turns in a round room whose wall is 2 m away. @param step [m] of the ranges' quantisation
struct Turning {
  std::mt19937 random{1};
  double sigma = 0.004, step = 0.001;  // [m]
  std::unique_ptr<LaserScan> scan = std::make_unique<LaserScan>();

  const LaserScan& turn(int beams = 720) {
    std::normal_distribution<double> noise(0.0, sigma);
    scan->size = 0;
    for (int i = 0; i < beams; ++i) {
      const double range = step * std::round((2.0 + noise(random)) / step);
      scan->push({static_cast<float>(range), static_cast<float>(2.0 * std::numbers::pi * i / beams), 0.0F, 0.0F});
    }
    return *scan;
  }
};

TEST(StuckScanDetector, TrustsALidarAtRestHoweverCoarseItsSteps) {
  for (const double step : {0.00025, 0.001, 0.004}) {
    Turning lidar{.step = step};
    StuckScanDetector watch;
    for (int i = 0; i < 50; ++i) ASSERT_FALSE(watch.isStuck(lidar.turn())) << step;
  }
}

TEST(StuckScanDetector, NoticesARepeatedTurnAndItsEnd) {
  Turning lidar;
  StuckScanDetector watch;
  for (int i = 0; i < 5; ++i) watch.isStuck(lidar.turn());
  int turns = 0;
  while (!watch.isStuck(*lidar.scan)) ASSERT_LT(++turns, 4);
  EXPECT_GE(turns, 1) << "one may be chance";
  EXPECT_TRUE(watch.isStuck(lidar.turn())) << "the first half may be old";
  EXPECT_FALSE(watch.isStuck(lidar.turn()));
}

TEST(StuckScanDetector, SaysNothingOfScansWithoutReturns) {
  Turning lidar;
  StuckScanDetector watch;
  lidar.turn();
  for (Beam& beam : lidar.scan->storage) beam.range = 0.0F;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(watch.isStuck(*lidar.scan));
}

TEST(StuckScanDetector, TakesAnyBearing) {
  const auto owned = std::make_unique<LaserScan>();
  LaserScan& scan = *owned;
  for (const float bearing : {-100.0F, -3.2F, 3.1415927F, 6.2831855F, 1e9F}) scan.push({2.0F, bearing, 0.0F, 0.0F});
  StuckScanDetector watch;
  EXPECT_FALSE(watch.isStuck(scan));
}

}  // namespace
}  // namespace slam
