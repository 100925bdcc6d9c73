// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/device_status.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

TEST(DeviceStatus, SaysWhatItDoesWhileItIsOpenedForTheFirstTime) {
  DeviceStatus status;
  status.setOpening("opening");
  EXPECT_STREQ(status.reason, "opening");
  status.setOpening("waiting");
  EXPECT_STREQ(status.reason, "waiting");
  EXPECT_EQ(status.state, DeviceState::kOpening);
}

TEST(DeviceStatus, KeepsSayingWhatIsWrongUntilItStreamsAgain) {
  for (const DeviceState failed : {DeviceState::kStale, DeviceState::kFault}) {
    DeviceStatus status;
    status.set(DeviceState::kStreaming, "");
    status.set(failed, "no data: check 5 V supply");
    status.setOpening("opening");
    EXPECT_EQ(status.state, DeviceState::kOpening);
    status.setOpening("waiting");
    EXPECT_STREQ(status.reason, "no data: check 5 V supply");
    status.set(DeviceState::kStreaming, "");
    EXPECT_STREQ(status.reason, "");
    status.set(DeviceState::kAbsent, "no such port");
    status.setOpening("opening");
    EXPECT_STREQ(status.reason, "opening") << "its return is news";
  }
}

}  // namespace
}  // namespace slam
