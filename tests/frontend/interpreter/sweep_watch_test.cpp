// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/sweep_watch.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "support/simulated/room.hpp"

namespace slam::test::sweep_watch_test {
namespace {

constexpr RangeLimits kLimits{0.05F, 12.0F};
constexpr double kInterval = 0.2;  // [s]

/// A robot that turns on the spot, and whose lidar measures its beams in this order.
SweepWatch::Order orderFoundOf(SweepWatch::Order truth, double turn_rate, bool gyro_wrong = false,
                               bool upside_down = false) {
  const Room room{.length = 8.0, .width = 5.0, .range_sigma = 0.01};
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, room.range_sigma);
  SweepWatch watch(upside_down);
  for (int i = 0; i < 40; ++i) {
    std::vector<Beam> beams;
    const auto poseAt = [&](double time, double scale) {
      return Pose2{1.0, 0.4, wrapAngle(scale * turn_rate * (kInterval * i + time))};
    };
    for (int k = 0; k < 360; ++k) {
      const double share = k / 360.0, bearing = wrapAngle(2.0 * std::numbers::pi * share);
      const double time = truth == SweepWatch::Order::kAtOnce    ? 0.0
                          : truth == SweepWatch::Order::kForward ? kInterval * share
                                                                 : kInterval * (1.0 - share);
      beams.push_back(
          {.range = static_cast<float>(room.range(poseAt(time, 1.0), upside_down ? -bearing : bearing) + noise(random)),
           .bearing = static_cast<float>(bearing)});
    }
    const double scale = gyro_wrong ? 1.02 : 1.0;
    watch.add(beams, kLimits, Timestamp(fromSeconds(kInterval * i)), kInterval,
              {poseAt(0.0, scale), poseAt(kInterval, scale)});
  }
  return watch.order();
}

TEST(SweepWatch, FindsTheOrderOfBeamsWithoutTimes) {
  for (const double rate : {1.5, -1.5, 0.9}) {
    EXPECT_EQ(orderFoundOf(SweepWatch::Order::kForward, rate), SweepWatch::Order::kForward) << rate;
    EXPECT_EQ(orderFoundOf(SweepWatch::Order::kReverse, rate), SweepWatch::Order::kReverse) << rate;
  }
}

TEST(SweepWatch, LeavesScansThatWereMeasuredAtOnce) {
  for (const double rate : {1.5, -1.5, 0.9}) {
    EXPECT_EQ(orderFoundOf(SweepWatch::Order::kAtOnce, rate), SweepWatch::Order::kAtOnce) << rate;
    EXPECT_EQ(orderFoundOf(SweepWatch::Order::kAtOnce, rate, true), SweepWatch::Order::kAtOnce) << rate;
  }
}

TEST(SweepWatch, FindsTheOrderOfALidarUpsideDown) {
  for (const auto order : {SweepWatch::Order::kAtOnce, SweepWatch::Order::kForward, SweepWatch::Order::kReverse}) {
    for (const double rate : {1.5, -0.9}) EXPECT_EQ(orderFoundOf(order, rate, false, true), order) << rate;
  }
}

TEST(SweepWatch, ASlowTurnGivesNothing) {
  EXPECT_EQ(orderFoundOf(SweepWatch::Order::kForward, 0.3), SweepWatch::Order::kAtOnce);
}

}  // namespace
}  // namespace slam::test::sweep_watch_test
