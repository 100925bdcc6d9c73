// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/range_noise_watch.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

#include "support/simulated/room.hpp"

namespace slam::test::range_noise_watch_test {
namespace {

constexpr RangeLimits kLimits{0.15F, 30.0F};

/// Looks from where the robot is at each time, at rest by wheels and gyro.
class RangeNoiseWatchTest : public testing::Test {
 protected:
  void look(const Room& room, const Pose2& truth = {}, bool at_rest = true) {
    const LaserScan scan = room.scan(truth, random_);
    std::vector<Beam> beams(scan.beams().begin(), scan.beams().end());
    watch_.add(beams, kLimits, at_rest);
  }

  RangeNoiseWatch watch_;
  std::mt19937 random_{1};
};

TEST_F(RangeNoiseWatchTest, MeasuresTheNoiseAtRest) {
  for (const double sigma : {0.01, 0.05, 0.3}) {
    watch_ = RangeNoiseWatch();
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(watch_.sigma(), 0.0) << "known after five scans";
      look({.length = 6.0, .width = 5.0, .range_sigma = sigma});
    }
    EXPECT_NEAR(watch_.sigma(), sigma, 0.25 * sigma);
    EXPECT_EQ(watch_.tooNoisy(), sigma > 0.15);
  }
}

TEST_F(RangeNoiseWatchTest, ARobotThatIsSuddenlyElsewhereIsNotNoisy) {
  for (int i = 0; i < 20; ++i) {
    look({.length = 6.0, .width = 5.0, .range_sigma = 0.01}, i < 10 ? Pose2{} : Pose2{2.0, 1.5, 1.0});
    EXPECT_FALSE(watch_.tooNoisy()) << i;
  }
}

TEST_F(RangeNoiseWatchTest, ALidarThatIsCleanedIsUsedAgainAfterFewScans) {
  for (int i = 0; i < 8; ++i) look({.length = 6.0, .width = 5.0, .range_sigma = 0.3});
  ASSERT_TRUE(watch_.tooNoisy());
  for (int i = 0; i < 3; ++i) look({.length = 6.0, .width = 5.0, .range_sigma = 0.0});
  EXPECT_FALSE(watch_.tooNoisy());
}

TEST_F(RangeNoiseWatchTest, AMotionThatWheelsAndGyroDoNotReportIsNoNoise) {
  for (int i = 0; i < 20; ++i) look({.length = 6.0, .width = 5.0, .range_sigma = 0.01}, {-2.0 + 0.2 * i, 0.0, 0.0});
  EXPECT_GT(watch_.sigma(), 0.0);
  EXPECT_LT(watch_.sigma(), 0.05) << "pushed at 1 to 2 m/s";
}

TEST_F(RangeNoiseWatchTest, OfARobotInMotionNothingIsKnown) {
  const Room noisy{.length = 6.0, .width = 5.0, .range_sigma = 0.3};
  for (int i = 0; i < 30; ++i) look(noisy, {}, i % 3 != 0);
  EXPECT_EQ(watch_.sigma(), 0.0) << "never three scans in a row at rest";
}

TEST_F(RangeNoiseWatchTest, NoiseThatGrowsWithRangeLeavesNearWalls) {
  std::normal_distribution<double> normal;
  for (int i = 0; i < 10; ++i) {
    std::vector<Beam> beams;
    for (int k = 0; k < 360; ++k) {
      const double range = k % 2 == 0 ? 3.0 : 20.0;
      beams.push_back({.range = static_cast<float>(range * (1.0 + 0.025 * normal(random_))),
                       .bearing = static_cast<float>(k * M_PI / 180.0)});
    }
    watch_.add(beams, kLimits, true);
  }
  EXPECT_NEAR(watch_.sigma(), 0.025 * 3.0, 0.02);
  EXPECT_FALSE(watch_.tooNoisy());
}

TEST_F(RangeNoiseWatchTest, TooFewBearingsAndBadOnesGiveNothing) {
  const std::vector<Beam> few(19, {.range = 3.0F});
  std::vector<Beam> bad(400, {.range = 3.0F, .bearing = std::numeric_limits<float>::quiet_NaN()});
  for (int k = 0; k < 200; ++k)
    bad[static_cast<std::size_t>(k)] = {.range = std::nanf(""), .bearing = 0.1F * static_cast<float>(k)};
  for (int i = 0; i < 10; ++i) {
    watch_.add(few, kLimits, true);
    watch_.add(bad, kLimits, true);
  }
  EXPECT_EQ(watch_.sigma(), 0.0);
}

}  // namespace
}  // namespace slam::test::range_noise_watch_test
