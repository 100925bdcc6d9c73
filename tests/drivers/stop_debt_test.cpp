// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/stop_debt.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

TEST(StopDebt, IsOwedFromTheStartUntilAllZerosWereAccepted) {
  StopDebt stop(2);
  EXPECT_TRUE(stop.owed());
  stop.zeroAccepted();
  EXPECT_TRUE(stop.owed());
  stop.zeroAccepted();
  EXPECT_FALSE(stop.owed());
  stop.zeroAccepted();
  EXPECT_FALSE(stop.owed());
}

TEST(StopDebt, IsOwedInFullAgain) {
  StopDebt stop(2);
  stop.zeroAccepted();
  stop.owe();
  stop.zeroAccepted();
  EXPECT_TRUE(stop.owed());
  stop.zeroAccepted();
  EXPECT_FALSE(stop.owed());
}

TEST(StopDebt, IsNeverOwedWhereNothingMayBeSent) {
  StopDebt stop(0);
  EXPECT_FALSE(stop.owed());
  stop.owe();
  EXPECT_FALSE(stop.owed());
}

}  // namespace
}  // namespace slam
