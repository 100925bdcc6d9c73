// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/slamd_base/base_frame.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <random>
#include <string>

#include "build_paths.hpp"

namespace slamd_base {
namespace {

using Bytes = std::vector<std::uint8_t>;

// The examples of docs/base-frame.md; their checksums were computed by another program than this one.
const Bytes kStateBytes{0xC3, 0x9E, 0x01, 0x14, 0x40, 0x42, 0x0F, 0x00, 0xE8, 0x03, 0x00, 0x00, 0xFB,
                        0xFF, 0xFF, 0xFF, 0x70, 0x2F, 0xFC, 0xFF, 0x44, 0x2F, 0x07, 0x09, 0x98, 0x00};
const Bytes kSpeedsBytes{0xC3, 0x9E, 0x81, 0x09, 0x07, 0xE8, 0x03, 0x00, 0x00, 0x18, 0xFC, 0xFF, 0xFF, 0x70, 0xB2};
const Bytes kStopBytes{0xC3, 0x9E, 0x81, 0x09, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x1D, 0x89};
const State kExample{1000000, {1000, -5}, -250000, 12100, 7, kHasGyro | kDriven};

std::vector<Bytes> framesIn(const Bytes& bytes, Receiver& receiver) {
  std::vector<Bytes> frames;
  for (const std::uint8_t byte : bytes)
    receiver.push(byte, [&](const std::uint8_t* frame) { frames.emplace_back(frame, frame + kHead + frame[3] + 2); });
  return frames;
}
Bytes encoded(const State& state) {
  Bytes bytes(kLongestFrame);
  bytes.resize(encodeState(state, bytes.data()));
  return bytes;
}
Bytes encoded(const Speeds& speeds) {
  Bytes bytes(kLongestFrame);
  bytes.resize(encodeSpeeds(speeds, bytes.data()));
  return bytes;
}
std::string hexOf(const Bytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    char digits[4];
    std::snprintf(digits, sizeof digits, "%s%02X", text.empty() ? "" : " ", static_cast<unsigned>(byte));
    text += digits;
  }
  return text;
}

TEST(BaseFrame, IsWrittenAsInItsDocument) {
  EXPECT_EQ(encoded(kExample), kStateBytes);
  EXPECT_EQ(encoded(Speeds{7, {1000, -1000}}), kSpeedsBytes);
  EXPECT_EQ(encoded(Speeds{8, {0, 0}}), kStopBytes);
  std::ifstream file(SLAMD_SOURCE_DIR "/docs/base-frame.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const Bytes& example : {kStateBytes, kSpeedsBytes, kStopBytes})
    EXPECT_NE(page.find("`" + hexOf(example) + "`"), std::string::npos) << hexOf(example);
}

TEST(BaseFrame, HasTheChecksumOfItsCatalogue) {
  const std::string text = "123456789";
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  EXPECT_EQ(crc16(bytes, text.size(), 0xFFFF), 0x29B1) << "CRC-16/IBM-3740";
  EXPECT_EQ(crc16(bytes, text.size(), 0x0000), 0x31C3) << "CRC-16/XMODEM";
}

TEST(BaseFrame, IsReadAsItWasWritten) {
  State state;
  ASSERT_TRUE(parseState(kStateBytes.data(), &state));
  EXPECT_EQ(encoded(state), kStateBytes);
  Speeds speeds;
  ASSERT_TRUE(parseSpeeds(kSpeedsBytes.data(), &speeds));
  EXPECT_EQ(encoded(speeds), kSpeedsBytes);
  EXPECT_FALSE(parseState(kSpeedsBytes.data(), &state)) << "of another type";
  EXPECT_FALSE(parseSpeeds(kStateBytes.data(), &speeds));
  const State extreme{UINT32_MAX, {INT32_MIN, INT32_MAX}, INT32_MIN, UINT16_MAX, 255, 255};
  ASSERT_TRUE(parseState(encoded(extreme).data(), &state));
  EXPECT_EQ(encoded(state), encoded(extreme));
}

TEST(BaseFrame, MayBeLongerThanIsKnownButNotShorter) {
  const auto resized = [](std::size_t payload) {
    Bytes frame(kStateBytes.begin(), kStateBytes.end() - 2);
    frame.resize(kHead + payload, 0x77);
    frame[3] = static_cast<std::uint8_t>(payload);
    const std::uint16_t crc = crc16(frame.data() + 2, frame.size() - 2, 0xFFFF);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    return frame;
  };
  Receiver receiver;
  State state;
  for (const std::size_t payload : {20U, 21U, 32U}) {
    const auto frames = framesIn(resized(payload), receiver);
    ASSERT_EQ(frames.size(), 1U) << payload;
    EXPECT_TRUE(parseState(frames[0].data(), &state));
    EXPECT_EQ(state.counts[1], -5);
  }
  const auto frames = framesIn(resized(19), receiver);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_FALSE(parseState(frames[0].data(), &state));
  EXPECT_TRUE(framesIn(resized(33), receiver).empty()) << "longer than a receiver holds";
  EXPECT_EQ(framesIn(kStateBytes, receiver).size(), 1U);
}

TEST(BaseFrame, IsFoundBehindDamageAndInsideOfWhatLooksLikeAHead) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    Receiver receiver;
    Bytes bytes = kStateBytes;
    const std::size_t at = random() % bytes.size();
    switch (i % 3) {
      case 0:
        bytes[at] ^= static_cast<std::uint8_t>(1 + random() % 255);
        break;
      case 1:
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      default:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), 0xC3);
    }
    for (int k = 0; k < 2; ++k) bytes.insert(bytes.end(), kStateBytes.begin(), kStateBytes.end());
    const auto frames = framesIn(bytes, receiver);
    ASSERT_GE(frames.size(), 1U) << "a false head holds at most 38 bytes";
    EXPECT_EQ(frames.back(), kStateBytes);
  }
}

TEST(BaseFrame, IsNotFoundInNoise) {
  std::mt19937 random(4);
  Receiver receiver;
  Bytes bytes(200000);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  EXPECT_TRUE(framesIn(bytes, receiver).empty());
  EXPECT_EQ(framesIn(Bytes(300, 0xC3), receiver).size(), 0U);
  framesIn(Bytes(38, 0), receiver);
  EXPECT_EQ(framesIn(kSpeedsBytes, receiver).size(), 1U);
}

}  // namespace
}  // namespace slamd_base
