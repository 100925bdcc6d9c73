// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_texts.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

using can::odrive::Heartbeat;

TEST(CanTexts, NameInterfaceAndMend) {
  const CanTexts texts("can7", {0x10, 0x18});
  EXPECT_STREQ(texts.link(CanLinkState::kDown), "can7 is down: ip link set can7 up");
  EXPECT_STREQ(texts.link(CanLinkState::kGone), "interface can7 is gone: adapter unplugged?");
  EXPECT_STREQ(texts.link(CanLinkState::kBusOff), "can7 is bus-off: check wiring and termination");
  EXPECT_STREQ(texts.link(CanLinkState::kUp), "");
  for (const auto state : {CanLinkState::kUnsupported, CanLinkState::kRefused, CanLinkState::kErrorPassive})
    EXPECT_STRNE(texts.link(state), "");
}

TEST(CanTexts, NameTheWheelAndItsNode) {
  const CanTexts texts("can0", {0x05, 0x3F});
  EXPECT_EQ(texts.no_frames[0], "no frames of the left wheel (node 0x05)");
  EXPECT_EQ(texts.no_frames[1], "no frames of the right wheel (node 0x3f)");
}

TEST(CanTexts, SayWhatADriveReports) {
  CanTexts texts("can0", {0x10, 0x18});
  EXPECT_STREQ(texts.axis(0, {.axis_error = 0x40, .state = 1, .motor_error = true}),
               "left wheel: axis error 0x40, motor, disarmed");
  EXPECT_STREQ(texts.axis(1, {.axis_error = 0xFFFFFFFF, .state = 8, .encoder_error = true, .controller_error = true}),
               "right wheel: axis error 0xffffffff, encoder, controller, still in closed loop");
}

TEST(CanTexts, UseOneTextForOneError) {
  CanTexts texts("can0", {0x10, 0x18});
  const char* first = texts.axis(0, {.axis_error = 1});
  EXPECT_EQ(texts.axis(0, {.axis_error = 1, .trajectory_done = true}), first);
  EXPECT_NE(texts.axis(1, {.axis_error = 1}), first);
}

}  // namespace
}  // namespace slam
