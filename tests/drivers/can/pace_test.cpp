// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/pace.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

using namespace std::chrono_literals;

TEST(Pace, IsTheMiddleOfTheLastThreeSteps) {
  Pace pace;
  EXPECT_EQ(pace.period(), 0s);
  Timestamp stamp{1000s};
  const auto after = [&](Duration step) {
    pace.add(stamp += step);
    return pace.period();
  };
  EXPECT_EQ(after(0s), 0s) << "one frame has no period";
  EXPECT_EQ(after(100ms), 100ms);
  EXPECT_EQ(after(100ms), 100ms);
  EXPECT_EQ(after(300ms), 100ms) << "one was lost";
  EXPECT_EQ(after(1ms), 100ms);
  EXPECT_EQ(after(100ms), 100ms);
  after(60s);
  EXPECT_EQ(after(60s), 2s) << "what comes so seldom has none";
}

}  // namespace
}  // namespace slam
