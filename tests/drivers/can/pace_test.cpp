// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/pace.hpp"

#include <gtest/gtest.h>

namespace slam::pace_test {
namespace {

using namespace std::chrono_literals;

class PaceTest : public testing::Test {
 protected:
  Duration after(Duration step) {
    pace_.add(stamp_ += step);
    return pace_.period();
  }

  Pace pace_;
  Timestamp stamp_{1000s};
};

TEST_F(PaceTest, IsTheMiddleOfThreeStepsThatAgree) {
  EXPECT_EQ(pace_.period(), 0s);
  EXPECT_EQ(after(0s), 0s) << "one frame has no period";
  EXPECT_EQ(after(300ms), 300ms);
  EXPECT_EQ(after(100ms), 100ms) << "a frame was lost before";
  EXPECT_EQ(after(110ms), 100ms);
  EXPECT_EQ(after(105ms), 105ms);
  EXPECT_EQ(after(300ms), 105ms) << "one was lost";
  EXPECT_EQ(after(1ms), 105ms);
  for (int i = 0; i < 3; ++i) after(60s);
  EXPECT_EQ(pace_.period(), 2s) << "what comes so seldom has none";
}

TEST_F(PaceTest, OutlivesABusThatFailsAgainAndAgain) {
  for (int i = 0; i < 4; ++i) after(100ms);
  for (const Duration step : {1100ms, 500ms, 700ms, 1900ms, 1200ms, 640ms, 1300ms}) EXPECT_EQ(after(step), 100ms);
}

}  // namespace
}  // namespace slam::pace_test
