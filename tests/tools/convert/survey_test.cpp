// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/survey.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace slam::survey_test {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::size_t kBeams = 181;

RangeCensus ofARoom(unsigned seed, int scans) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> range(0.3, 9.0);
  RangeCensus census;
  for (int i = 0; i < scans; ++i) {
    for (std::size_t k = 0; k < kBeams; ++k) census.add(k, kBeams, std::round(range(random) * 100.0) * 0.01);
  }
  return census;
}

TEST(RangeCensus, FindsWhatManyDirectionsShareAtTheRim) {
  RangeCensus census = ofARoom(1, 100);
  EXPECT_THAT(census.codes(), IsEmpty());
  for (std::size_t k = 0; k < 3000; ++k) census.add(k % kBeams, kBeams, k % 10 == 0 ? 12.003 : 12.5);
  EXPECT_THAT(census.codes(), ElementsAre(DoubleNear(12.003, 1e-9), DoubleNear(12.5, 1e-9)));
  EXPECT_NEAR(census.largest(), 12.5, 1e-9);
  EXPECT_NEAR(census.limit(), 12.003 - RangeCensus::kStep, 1e-9);
  EXPECT_NEAR(ofARoom(1, 100).limit(), ofARoom(1, 100).largest() + 0.01, 1e-9);
}

TEST(RangeCensus, TakesNoWallForACode) {
  RangeCensus still = ofARoom(2, 100);
  for (int i = 0; i < 500; ++i) still.add(90, kBeams, 9.5);  // the robot stands, and one beam sees the same again
  EXPECT_THAT(still.codes(), IsEmpty());
  RangeCensus inside = ofARoom(3, 100);
  for (std::size_t i = 0; i < 3000; ++i) inside.add(i % kBeams, kBeams, 4.0);  // far below the rim
  EXPECT_THAT(inside.codes(), IsEmpty());
  RangeCensus round;
  for (std::size_t i = 0; i < 3000; ++i) round.add(i % kBeams, kBeams, 2.0);  // all that there is
  EXPECT_THAT(round.codes(), IsEmpty());
}

TEST(RangeCensus, PassesOverWhatIsNoRange) {
  RangeCensus census;
  for (const double bad : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) census.add(0, kBeams, bad);
  census.add(0, 0, 1.0);
  EXPECT_TRUE(census.empty());
  EXPECT_THAT(census.codes(), IsEmpty());
  census.add(400, kBeams, 1.0);
  EXPECT_FALSE(census.empty());
}

}  // namespace
}  // namespace slam::survey_test
