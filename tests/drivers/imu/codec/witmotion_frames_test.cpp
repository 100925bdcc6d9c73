// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/codec/witmotion_frames.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

namespace slam::witmotion::witmotion_frames_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Computed by [WIT].
const Bytes kGravity{0x55, 0x51, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0xC4, 0x09, 0x7B};
const Bytes kTurn{0x55, 0x52, 0x00, 0x00, 0x00, 0x00, 0xA4, 0x00, 0x00, 0x00, 0x4B};
const Bytes kAngle{0x55, 0x53, 0x00, 0x00, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0xE8};

std::vector<Frame> framesIn(const Bytes& bytes) {
  Decoder decoder;
  std::vector<Frame> frames;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) { frames.push_back(parse(frame)); });
  return frames;
}

TEST(WitmotionFrames, AreReadInTheirUnits) {
  Bytes bytes = kGravity;
  for (const Bytes& more : {kTurn, kAngle}) bytes.insert(bytes.end(), more.begin(), more.end());
  const auto frames = framesIn(bytes);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].type, Type::kAcceleration);
  EXPECT_DOUBLE_EQ(frames[0].raw[2] * kGravitiesPerCount, 1.0);
  EXPECT_EQ(frames[1].type, Type::kTurnRate);
  EXPECT_NEAR(frames[1].raw[2] * kRadiansPerSecondPerCount, 10.0 * std::numbers::pi / 180.0, 1e-3);
  EXPECT_EQ(frames[2].type, Type::kAngle);
  EXPECT_EQ(frames[2].raw[2], 16384);
}

TEST(WitmotionFrames, AreWrittenAsTheyAreRead) {
  for (const Bytes& bytes : {kGravity, kTurn, kAngle}) {
    const auto again = encode(framesIn(bytes).at(0));
    EXPECT_TRUE(std::equal(again.begin(), again.end(), bytes.begin(), bytes.end()));
  }
}

TEST(WitmotionFrames, OfOtherTypesKeepTheStepAndOthersDoNot) {
  const Frame quaternion{static_cast<Type>(0x59), {100, 200, 300, 0x55}};
  const auto frame = encode(quaternion);
  Bytes bytes(frame.begin(), frame.end());
  bytes.insert(bytes.end(), kTurn.begin(), kTurn.end());
  ASSERT_EQ(framesIn(bytes).size(), 2U);
  EXPECT_EQ(framesIn(bytes)[0], quaternion);
  bytes[1] = 0x61;  // of WitMotion's Bluetooth units, in 20 bytes
  EXPECT_EQ(framesIn(bytes).size(), 1U);
}

TEST(WitmotionFrames, AreFoundBehindALostByte) {
  Bytes bytes(kTurn.begin() + 1, kTurn.end());
  bytes.insert(bytes.end(), kTurn.begin(), kTurn.begin() + 5);
  bytes.insert(bytes.end(), kTurn.begin() + 6, kTurn.end());
  bytes.insert(bytes.end(), kGravity.begin(), kGravity.end());
  ASSERT_EQ(framesIn(bytes).size(), 1U);
  EXPECT_EQ(framesIn(bytes)[0].type, Type::kAcceleration);
}

}  // namespace
}  // namespace slam::witmotion::witmotion_frames_test
