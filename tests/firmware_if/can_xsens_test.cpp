// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/can_xsens.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::can::xsens::can_xsens_test {
namespace {

using testing::Optional;

TEST(CanXsens, RateOfTurnIsTheReferenceFrame) {
  const Frame frame{.id = 0x032, .size = 6, .data = {0x01, 0x00, 0x00, 0x00, 0xFF, 0x80}};
  EXPECT_THAT(parseRateOfTurn(frame), Optional(Vector3{0.5F, 0.0F, -0.25F}));
  EXPECT_EQ(encodeRateOfTurn({0.5F, 0.0F, -0.25F}), frame);
}

TEST(CanXsens, AccelerationIsTheReferenceFrame) {
  const Frame frame{.id = 0x034, .size = 6, .data = {0x00, 0x00, 0x00, 0x00, 0x09, 0xCF}};
  const auto value = parseAcceleration(frame);
  ASSERT_TRUE(value);
  EXPECT_NEAR((*value)[2], 9.81F, 0.5F / 256.0F);
  EXPECT_EQ(encodeAcceleration({0.0F, 0.0F, 9.81F}), frame);
}

TEST(CanXsens, SampleTimeIsBigEndian) {
  const Frame frame{.id = 0x005, .size = 4, .data = {0x00, 0x01, 0x86, 0xA0}};
  EXPECT_THAT(parseSampleTime(frame), Optional(100000U));
  EXPECT_EQ(encodeSampleTime(100000), frame);
}

TEST(CanXsens, QuaternionsAreFractionsOfTheLargest) {
  EXPECT_EQ(encodeQuaternion({0.5F, -0.5F, 0.7F, -1.0F}),
            (Frame{.id = kQuaternion, .size = 8, .data = {0x40, 0x00, 0xC0, 0x00, 0x59, 0x99, 0x80, 0x01}}));
}

TEST(CanXsens, WhatDoesNotFitIsCutOffAtTheLargest) {
  EXPECT_THAT(parseRateOfTurn(encodeRateOfTurn({1000.0F, -1000.0F, 0.0F})),
              Optional(Vector3{32767.0F / 512.0F, -64.0F, 0.0F}));
}

TEST(CanXsens, RefusesWhatIsNotItsFrame) {
  const Frame rate = encodeRateOfTurn({}), time = encodeSampleTime(5);
  for (std::uint8_t size = 0; size <= 8; ++size) {
    const auto resized = [size](Frame frame) {
      frame.size = size;
      return frame;
    };
    EXPECT_EQ(parseRateOfTurn(resized(rate)).has_value(), size == 6);
    EXPECT_EQ(parseSampleTime(resized(time)).has_value(), size == 4);
  }
  EXPECT_FALSE(parseAcceleration(rate));
  for (bool Frame::*kind : {&Frame::extended, &Frame::remote, &Frame::error}) {
    Frame frame = rate;
    frame.*kind = true;
    EXPECT_FALSE(parseRateOfTurn(frame));
  }
}

TEST(CanXsensTicks, GoOnWhereTheCounterWraps) {
  TickCounter ticks;
  EXPECT_EQ(ticks.count(0xFFFFFF00U), 0xFFFFFF00LL);
  EXPECT_EQ(ticks.count(0x00000064U), 0x100000064LL);
  EXPECT_EQ(ticks.count(0x00000064U), 0x100000064LL) << "the same tick again";
  EXPECT_EQ(ticks.count(0x000000C8U), 0x1000000C8LL);
}

TEST(CanXsensTicks, BeginAnewWithTheUnit) {
  TickCounter ticks;
  ticks.count(18'000'000);  // half an hour
  EXPECT_EQ(ticks.count(100), 100);
  EXPECT_EQ(ticks.count(200), 200);
}

}  // namespace
}  // namespace slam::can::xsens::can_xsens_test
