// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/can_vesc.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::can::vesc::can_vesc_test {
namespace {

// Computed by the public description: 3000 ERPM, 12.5 A, duty 0.5 of id 10.
const Frame kStatus{.id = 0x90A, .size = 8, .extended = true, .data = {0x00, 0x00, 0x0B, 0xB8, 0x00, 0x7D, 0x01, 0xF4}};
// -123456 steps, 12.1 V.
const Frame kStatus5{.id = 0x1B0A, .size = 8, .extended = true, .data = {0xFF, 0xFE, 0x1D, 0xC0, 0x00, 0x79, 0, 0}};

TEST(CanVesc, ReadsAndWritesWhatThePublicDescriptionHas) {
  EXPECT_EQ(parseStatus(10, kStatus), (Status{3000, 125, 500}));
  EXPECT_EQ(encode(10, Status{3000, 125, 500}), kStatus);
  EXPECT_EQ(parseStatus5(10, kStatus5), (Status5{-123456, 121}));
  EXPECT_EQ(encode(10, Status5{-123456, 121}), kStatus5);
  const Frame rpm = encodeSetRpm(10, 3000);
  EXPECT_EQ(rpm, (Frame{.id = 0x30A, .size = 4, .extended = true, .data = {0x00, 0x00, 0x0B, 0xB8}}));
  EXPECT_EQ(parseSetRpm(10, rpm), 3000);
  EXPECT_EQ(parseStatus4(7, encode(7, Status4{851, -20, 33, 17999})), (Status4{851, -20, 33, 17999}));
}

TEST(CanVesc, RefusesFramesOfOthersAndShortOnes) {
  EXPECT_FALSE(parseStatus(11, kStatus)) << "another controller";
  EXPECT_FALSE(parseStatus(10, kStatus5)) << "another packet";
  for (const auto damage : {+[](Frame& frame) { frame.extended = false; }, +[](Frame& frame) { frame.remote = true; },
                            +[](Frame& frame) { frame.error = true; }, +[](Frame& frame) { frame.size = 5; }}) {
    Frame status = kStatus, tachometer = kStatus5;
    damage(status);
    damage(tachometer);
    EXPECT_FALSE(parseStatus(10, status));
    EXPECT_FALSE(parseStatus5(10, tachometer));
  }
  Frame shorter = kStatus5;
  shorter.size = 6;
  EXPECT_TRUE(parseStatus5(10, shorter)) << "two of its bytes are reserved";
}

TEST(CanVesc, GoesThereAndBack) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const int id = static_cast<int>(random() % 255);
    const auto any = [&] { return static_cast<std::int16_t>(random()); };
    const Status status{static_cast<std::int32_t>(random()), any(), any()};
    const Status5 tachometer{static_cast<std::int32_t>(random()), any()};
    EXPECT_EQ(parseStatus(id, encode(id, status)), status);
    EXPECT_EQ(parseStatus5(id, encode(id, tachometer)), tachometer);
    EXPECT_EQ(parseSetRpm(id, encodeSetRpm(id, status.erpm)), status.erpm);
  }
}

}  // namespace
}  // namespace slam::can::vesc::can_vesc_test
