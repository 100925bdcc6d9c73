// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/no_return_watch.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "support/simulated/room.hpp"

namespace slam::test::no_return_watch_test {
namespace {

constexpr RangeLimits kLimits{0.05F, 30.0F};

/// What a lidar with a reach of `room.reach` writes, one of the codes where nothing came back.
std::vector<Beam> look(const Room& room, const Pose2& truth, const std::vector<float>& codes, double step = 0.0) {
  std::mt19937 random(1);
  const LaserScan scan = room.scan(truth, random);
  std::vector<Beam> beams(scan.beams().begin(), scan.beams().end());
  std::size_t next = 0;
  for (Beam& beam : beams) {
    if (step > 0.0) beam.range = static_cast<float>(step * std::round(beam.range / step));
    if (beam.range <= 0.0F || beam.range > room.reach) beam.range = codes[next++ % codes.size()];
  }
  return beams;
}

TEST(NoReturnWatch, FindsTheEndOfTheReachAtOnceInAHall) {
  NoReturnWatch watch;
  watch.add(look({.length = 40.0, .width = 12.0, .reach = 8.0, .range_sigma = 0.01}, {}, {8.0F}), kLimits,
            Eigen::Vector2d(0, 0));
  ASSERT_EQ(watch.codes().size(), 1U);
  EXPECT_TRUE(watch.isCode(8.0F));
  EXPECT_FALSE(watch.isCode(7.99F));
}

TEST(NoReturnWatch, FindsSeveralValuesAtTheRimOfACorridorFromTwoPlaces) {
  NoReturnWatch watch;
  const Room corridor{.length = 60.0, .width = 2.0, .reach = 8.0, .range_sigma = 0.01};
  watch.add(look(corridor, {}, {8.183F, 8.187F}), kLimits, Eigen::Vector2d(0, 0));
  watch.add(look(corridor, {0.05, 0, 0}, {8.183F, 8.187F}), kLimits, Eigen::Vector2d(0.05, 0));
  EXPECT_TRUE(watch.codes().empty()) << "one place";
  watch.add(look(corridor, {0.2, 0, 0}, {8.183F, 8.187F}), kLimits, Eigen::Vector2d(0.2, 0));
  EXPECT_TRUE(watch.isCode(8.183F));
  EXPECT_TRUE(watch.isCode(8.187F));
  EXPECT_FALSE(watch.isCode(8.185F));
}

TEST(NoReturnWatch, FindsNoneInARoomSeenInStepsOfACentimetre) {
  NoReturnWatch watch;
  const Room room{.length = 4.0, .width = 4.0, .range_sigma = 0.0};
  for (int i = 0; i < 15; ++i) {
    const Pose2 pose{0.1 * i, 0.0, 0.0};
    watch.add(look(room, pose, {0.0F}, 0.01), kLimits, pose.translation());
  }
  EXPECT_TRUE(watch.codes().empty());
}

TEST(NoReturnWatch, WithoutMotionNothingIsAddedToTheFirstScan) {
  NoReturnWatch watch;
  const Room corridor{.length = 60.0, .width = 2.0, .reach = 8.0, .range_sigma = 0.01};
  for (int i = 0; i < 5; ++i) watch.add(look(corridor, {}, {10.0F}), kLimits, std::nullopt);
  EXPECT_TRUE(watch.codes().empty());
}

}  // namespace
}  // namespace slam::test::no_return_watch_test
