// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/hfi_imu.hpp"

#include <gmock/gmock.h>
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
using testing::ElementsAre;

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
const Bytes kGyroFrame{0x55, 0x52, 0xE8, 0x03, 0x30, 0xF8, 0x00, 0x40, 0x4D, 0x00, 0x47};
const Bytes kAccelFrame{0x55, 0x51, 0x00, 0x00, 0x00, 0x01, 0x00, 0xF8, 0x00, 0x00, 0x9F};

std::vector<Bytes> decodeA9(A9Decoder& decoder, const Bytes& bytes) {
  std::vector<Bytes> all;
  for (const std::uint8_t byte : bytes) {
    for (auto data = decoder.push(byte); data; data = decoder.flush()) all.emplace_back(data->begin(), data->end());
  }
  return all;
}

std::vector<B6Frame> decodeB6(B6Decoder& decoder, const Bytes& bytes) {
  std::vector<B6Frame> all;
  for (const std::uint8_t byte : bytes) {
    for (auto frame = decoder.push(byte); frame; frame = decoder.flush()) all.push_back(*frame);
  }
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
  const auto frames = decodeA9(decoder, kMotionFrame + kAttitudeFrame);
  ASSERT_EQ(frames.size(), 2U);
  const auto motion = parseA9Motion(frames[0]);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->gyro, kMotion.gyro);
  EXPECT_EQ(motion->accel, kMotion.accel);
  EXPECT_EQ(motion->magnetic, kMotion.magnetic);
  const auto attitude = parseA9Attitude(frames[1]);
  ASSERT_TRUE(attitude);
  EXPECT_EQ(attitude->roll, 1.5F);
  EXPECT_EQ(attitude->pitch, -2.5F);
  EXPECT_EQ(attitude->yaw, 90.0F);
  EXPECT_FALSE(parseA9Motion(frames[1]));
  EXPECT_FALSE(parseA9Attitude(frames[0]));
  EXPECT_EQ(decoder.counters().skipped_bytes, 0U);
}

TEST(HfiA9, RefusesWhatIsNotANumber) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    A9Motion motion = kMotion;
    motion.accel[axis] = std::numeric_limits<float>::quiet_NaN();
    A9Decoder decoder;
    EXPECT_FALSE(parseA9Motion(decodeA9(decoder, bytesOf(encodeA9(motion))).at(0)));
  }
}

TEST(HfiB6, IsEncodedByteForByteAndDecoded) {
  const B6Frame gyro{B6Type::kGyro, {1000, -2000, 16384, 77}};
  EXPECT_EQ(bytesOf(encodeB6(gyro)), kGyroFrame);
  B6Decoder decoder;
  const auto frames = decodeB6(decoder, kAccelFrame + kGyroFrame);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].type, B6Type::kAccel);
  EXPECT_THAT(frames[0].raw, ElementsAre(0, 256, -2048, 0));
  EXPECT_EQ(frames[1].type, B6Type::kGyro);
  EXPECT_EQ(frames[1].raw, gyro.raw);
  EXPECT_FLOAT_EQ(-2048.0F * kB6Accel, -1.0F);
  EXPECT_FLOAT_EQ(16384.0F * kB6Gyro, 17.453293F);
  EXPECT_FLOAT_EQ(16384.0F * kB6Angle, 90.0F);
}

TEST(HfiDecoders, LoseNothingBehindAFrameCutShort) {
  for (std::size_t size = 1; size < kMotionFrame.size(); ++size) {
    A9Decoder decoder;
    const Bytes cut(kMotionFrame.begin(), kMotionFrame.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(decodeA9(decoder, cut + kAttitudeFrame + kMotionFrame + kMotionFrame).size(), 3U) << "after " << size;
  }
  for (std::size_t size = 1; size < kGyroFrame.size(); ++size) {
    B6Decoder decoder;
    const Bytes cut(kGyroFrame.begin(), kGyroFrame.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(decodeB6(decoder, cut + kAccelFrame + kGyroFrame + Bytes(11)).size(), 2U) << "after " << size;
  }
}

TEST(HfiDecoders, CountABadChecksumAndUseTheNextFrame) {
  for (std::size_t at = 3; at < kMotionFrame.size(); ++at) {
    Bytes bad = kMotionFrame;
    bad[at] ^= 0x40;
    A9Decoder decoder;
    EXPECT_EQ(decodeA9(decoder, bad + kMotionFrame).size(), 1U);
    EXPECT_EQ(decoder.counters().bad_checksums, 1U);
  }
  Bytes bad = kGyroFrame;
  ++bad[5];
  B6Decoder decoder;
  EXPECT_EQ(decodeB6(decoder, bad + kGyroFrame).size(), 1U);
  EXPECT_EQ(decoder.counters().bad_checksums, 1U);
}

TEST(HfiDecoders, SurviveNoiseWithoutAllocating) {
  std::mt19937 random(4);
  constexpr std::uint8_t kLikely[] = {0xAA, 0x55, 0x2C, 0x14, 0x51, 0x52};
  Bytes noise(20000);
  for (auto& byte : noise) {
    byte = random() % 2 == 0 ? kLikely[random() % std::size(kLikely)] : static_cast<std::uint8_t>(random());
  }
  A9Decoder a9;
  B6Decoder b6;
  EXPECT_EQ(test::allocationsDuring([&] {
              for (const std::uint8_t byte : noise) {
                for (auto data = a9.push(byte); data; data = a9.flush()) {
                }
                for (auto frame = b6.push(byte); frame; frame = b6.flush()) {
                }
              }
            }),
            0U);
  EXPECT_LT(a9.counters().frames, 3U);
  EXPECT_EQ(decodeA9(a9, Bytes(64) + kMotionFrame).size(), 1U);
  EXPECT_EQ(decodeB6(b6, Bytes(64) + kGyroFrame).size(), 1U);
}

}  // namespace
}  // namespace slam::hfi::hfi_imu_test
