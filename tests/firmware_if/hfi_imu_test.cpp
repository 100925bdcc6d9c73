// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/hfi_imu.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

#include "firmware_if/bytes.hpp"
#include "support/allocations.hpp"

namespace slam::hfi::hfi_imu_test {
namespace {

using test::Bytes;
using test::operator+;

template <std::size_t N>
Bytes bytesOf(const std::array<std::uint8_t, N>& frame) {
  return {frame.begin(), frame.end()};
}

// Frames put together by an independent script from the rules of DEVICES.md 2.7.
const A9Motion kMotion{{0.5F, -0.25F, 1.0F}, {0.125F, -0.0625F, -1.0F}, {10.0F, 20.0F, 30.0F}};
const Bytes kMotionFrame{0xAA, 0x55, 0x2C, 0,    0,    0,    0, 0,    0,    0,    0, 0,    0,    0,    0x3F, 0, 0,
                         0x80, 0xBE, 0,    0,    0x80, 0x3F, 0, 0,    0,    0x3E, 0, 0,    0x80, 0xBD, 0,    0, 0x80,
                         0xBF, 0,    0,    0x20, 0x41, 0,    0, 0xA0, 0x41, 0,    0, 0xF0, 0x41, 0x74, 0x22};
const Bytes kAttitudeFrame{0xAA, 0x55, 0x14, 0, 0,    0,    0, 0, 0,    0,    0,    0,   0,
                           0xC0, 0x3F, 0,    0, 0x20, 0xC0, 0, 0, 0xB4, 0x42, 0xAC, 0x83};

std::vector<Bytes> decode(A9Decoder& decoder, const Bytes& bytes) {
  std::vector<Bytes> all;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) { all.emplace_back(frame.begin(), frame.end()); });
  return all;
}

TEST(HfiCrc, IsModbus) {
  const Bytes digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc16(digits), 0x4B37);
}

TEST(HfiA9, IsEncodedByteForByte) {
  EXPECT_EQ(bytesOf(encodeA9(kMotion)), kMotionFrame);
  EXPECT_EQ(bytesOf(encodeA9(A9Attitude{1.5F, -2.5F, 90.0F})), kAttitudeFrame);
}

TEST(HfiA9, HasItsFieldsBehindEightBytes) {
  A9Decoder decoder;
  const auto frames = decode(decoder, kMotionFrame + kAttitudeFrame);
  ASSERT_EQ(frames.size(), 2U);
  const auto motion = parseA9Motion(frames[0]);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->gyro, kMotion.gyro);
  EXPECT_EQ(motion->accel, kMotion.accel);
  EXPECT_EQ(motion->magnetic, kMotion.magnetic);
  EXPECT_FALSE(parseA9Motion(frames[1]));
  EXPECT_EQ(decoder.skipped(), 0U);
}

TEST(HfiA9, RefusesWhatIsNotANumber) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    A9Motion motion = kMotion;
    motion.accel[axis] = std::numeric_limits<float>::quiet_NaN();
    A9Decoder decoder;
    EXPECT_FALSE(parseA9Motion(decode(decoder, bytesOf(encodeA9(motion))).at(0)));
  }
}

TEST(HfiA9, LoseNothingBehindAFrameCutShort) {
  for (std::size_t size = 1; size < kMotionFrame.size(); ++size) {
    A9Decoder decoder;
    const Bytes cut(kMotionFrame.begin(), kMotionFrame.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(decode(decoder, cut + kAttitudeFrame + kMotionFrame + kMotionFrame).size(), 3U) << "after " << size;
  }
}

TEST(HfiA9, CountABadChecksumAndUseTheNextFrame) {
  for (std::size_t at = 3; at < kMotionFrame.size(); ++at) {
    Bytes bad = kMotionFrame;
    bad[at] ^= 0x40;
    A9Decoder decoder;
    EXPECT_EQ(decode(decoder, bad + kMotionFrame).size(), 1U);
    EXPECT_EQ(decoder.damaged(), 1U);
  }
}

TEST(HfiA9, SurviveNoiseWithoutAllocating) {
  std::mt19937 random(4);
  constexpr std::uint8_t kLikely[] = {0xAA, 0x55, 0x2C, 0x14};
  Bytes noise(20000);
  for (auto& byte : noise) {
    byte = random() % 2 == 0 ? kLikely[random() % std::size(kLikely)] : static_cast<std::uint8_t>(random());
  }
  A9Decoder decoder;
  int frames = 0;
  EXPECT_EQ(test::allocationsDuring([&] {
              for (const std::uint8_t byte : noise)
                decoder.push(byte, [&](std::span<const std::uint8_t>) { ++frames; });
            }),
            0U);
  EXPECT_LT(frames, 3);
  EXPECT_EQ(decode(decoder, Bytes(64) + kMotionFrame).size(), 1U);
}

}  // namespace
}  // namespace slam::hfi::hfi_imu_test
