// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/codec/bno08x_frames.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace slam::bno08x::bno08x_frames_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// [BNO08X], section 1.2.6.
const Bytes kExample{0xAA, 0xAA, 0xDE, 0x01, 0x00, 0x92, 0xFF, 0x25, 0x08, 0x8D,
                     0xFE, 0xEC, 0xFF, 0xD1, 0x03, 0x00, 0x00, 0x00, 0xE7};

std::vector<Frame> framesIn(const Bytes& bytes, Decoder& decoder) {
  std::vector<Frame> frames;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) { frames.push_back(parse(frame)); });
  return frames;
}
std::vector<Frame> framesIn(const Bytes& bytes) {
  Decoder decoder;
  return framesIn(bytes, decoder);
}

TEST(Bno08xFrames, AreReadAsInTheDataSheet) {
  const auto frames = framesIn(kExample);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], (Frame{.index = 222, .yaw = 1, .pitch = -110, .roll = 2085, .acceleration = {-371, -20, 977}}));
  const auto again = encode(frames[0]);
  EXPECT_TRUE(std::equal(again.begin(), again.end(), kExample.begin(), kExample.end()));
}

TEST(Bno08xFrames, HaveAnExampleWhoseAccelerationTurnsAboutOtherAxesThanItsText) {
  // Gravity in the unit's axes: roll about y tips x down, pitch about x tips y up.
  const Frame example = parse(kExample);
  const double radians = kDegreesPerCount * std::numbers::pi / 180.0;
  const double pitch = radians * example.pitch, roll = radians * example.roll;
  const auto [x, y, z] = example.acceleration;
  const double size = std::sqrt(x * x + y * y + z * z);
  EXPECT_NEAR(x, -size * std::sin(roll) * std::cos(pitch), 1.0);
  EXPECT_NEAR(y, size * std::sin(pitch), 1.0);
  EXPECT_NEAR(z, size * std::cos(roll) * std::cos(pitch), 1.0);
}

TEST(Bno08xFrames, AreReadWithOtherVectors) {
  const Bytes other{0xAA, 0xAA, 0xDE, 0x01, 0x00, 0x92, 0xFF, 0x02, 0x00, 0x18,
                    0xFC, 0x0C, 0xFE, 0xE8, 0x03, 0x00, 0x00, 0x00, 0x7B};
  EXPECT_EQ(
      framesIn(other),
      (std::vector<Frame>{{.index = 222, .yaw = 1, .pitch = -110, .roll = 2, .acceleration = {-1000, -500, 1000}}}));
  const Bytes right{0xAA, 0xAA, 0x01, 0xD8, 0xDC, 0x00, 0x00, 0x96, 0x00, 0x00,
                    0x00, 0x00, 0x00, 0xE8, 0x03, 0x00, 0x00, 0x00, 0x36};
  EXPECT_EQ(framesIn(right),
            (std::vector<Frame>{{.index = 1, .yaw = -9000, .pitch = 0, .roll = 150, .acceleration = {0, 0, 1000}}}));
}

TEST(Bno08xFrames, AreFoundBehindABannerAndDamage) {
  const std::string banner = "%Hillcrest Labs 10003608\r\n%SW Ver 3.2.x\r\n";
  Bytes bytes(banner.begin(), banner.end());
  bytes.insert(bytes.end(), {0xAA, 0xAA, 0xAA});  // a head before the head
  bytes.insert(bytes.end(), kExample.begin(), kExample.end());
  Bytes damaged = kExample;
  damaged[9] ^= 1;
  bytes.insert(bytes.end(), damaged.begin(), damaged.end());
  bytes.insert(bytes.end(), kExample.begin() + 1, kExample.end());  // a byte is lost
  bytes.insert(bytes.end(), kExample.begin(), kExample.end());
  Decoder decoder;
  EXPECT_EQ(framesIn(bytes, decoder).size(), 2U);
  EXPECT_GE(decoder.damaged(), 1U);
}

TEST(Bno08xFrames, MayHaveAnIndexLikeTheirHead) {
  Bytes bytes;
  for (int i = 0; i < 3; ++i) {
    const auto frame = encode({.index = 0xAA, .yaw = static_cast<std::int16_t>(0xAAAA)});
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  EXPECT_EQ(framesIn(bytes).size(), 3U);
}

}  // namespace
}  // namespace slam::bno08x::bno08x_frames_test
