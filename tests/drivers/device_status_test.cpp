// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/device_status.hpp"

#include <gtest/gtest.h>

#include "support/problems.hpp"

namespace slam::device_status_test {
namespace {

using test::problemOf;

TEST(DeviceStatus, ReportsWhatItDoesWhileItIsOpenedForTheFirstTime) {
  DeviceStatus status;
  status.setOpening(problemOf("opening"));
  EXPECT_EQ(status.problem().words(), "opening");
  status.setOpening(problemOf("waiting"));
  EXPECT_EQ(status.problem().words(), "waiting");
  EXPECT_EQ(status.state, DeviceState::kOpening);
}

TEST(DeviceStatus, KeepsWhatIsWrongUntilItStreamsAgain) {
  for (const DeviceState failed : {DeviceState::kStale, DeviceState::kFault}) {
    DeviceStatus status;
    status.set(DeviceState::kStreaming);
    status.set(failed, problemOf("no data: check 5 V supply"));
    status.setOpening(problemOf("opening"));
    EXPECT_EQ(status.state, DeviceState::kOpening);
    status.setOpening(problemOf("waiting"));
    EXPECT_EQ(status.problem().words(), "no data: check 5 V supply");
    status.set(DeviceState::kStreaming);
    EXPECT_EQ(status.problem().words(), "");
    status.set(DeviceState::kAbsent, problemOf("no such port"));
    status.setOpening(problemOf("opening"));
    EXPECT_EQ(status.problem().words(), "opening") << "its return is news";
  }
}

}  // namespace
}  // namespace slam::device_status_test
