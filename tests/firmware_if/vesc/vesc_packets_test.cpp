// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/vesc/vesc_packets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace slam::vesc::vesc_packets_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const Outgoing& out) { return {out.bytes().begin(), out.bytes().end()}; }

// Widely published: the question for the firmware. Computed by the open firmware's description: a speed of 3000.
const Bytes kAskVersion{0x02, 0x01, 0x00, 0x00, 0x00, 0x03};
const Bytes kSpeed{0x02, 0x05, 0x08, 0x00, 0x00, 0x0B, 0xB8, 0xF8, 0x04, 0x03};

TEST(VescPackets, AreWrittenAsPublished) {
  EXPECT_EQ(bytesOf(askVersion()), kAskVersion);
  EXPECT_EQ(bytesOf(setRpm(3000)), kSpeed);
  EXPECT_TRUE(Format::isGood(Bytes{0x02, 0x01, 0x04, 0x40, 0x84, 0x03})) << "the question for all values";
  EXPECT_TRUE(Format::isGood(Bytes{0x02, 0x05, 0x32, 0x00, 0x00, 0xA0, 0x80, 0xC4, 0x9B, 0x03})) << "selected ones";
  EXPECT_TRUE(isAskVersion(payloadOf(kAskVersion)));
  EXPECT_EQ(parseSetRpm(payloadOf(kSpeed)), 3000);
  EXPECT_EQ(parseSetRpm(payloadOf(bytesOf(setRpm(-7)))), -7);
}

TEST(VescPackets, AreForwardedWithoutAFrameOfTheirOwn) {
  const Bytes frame = bytesOf(forward(24, setRpm(3000)));
  EXPECT_TRUE(Format::isGood(frame));
  EXPECT_EQ(Bytes(frame.begin(), frame.end() - 3), (Bytes{0x02, 7, 34, 24, 0x08, 0x00, 0x00, 0x0B, 0xB8}));
  const Forwarded forwarded = parseForward(payloadOf(frame));
  EXPECT_EQ(forwarded.id, 24);
  EXPECT_EQ(parseSetRpm(forwarded.payload), 3000);
  EXPECT_TRUE(parseForward(payloadOf(kSpeed)).payload.empty());
}

TEST(VescPackets, HaveTheTurnInTheirSelection) {
  for (const Turn turn : {Turn::kEven, Turn::kOdd}) {
    EXPECT_EQ(parseAskValues(payloadOf(bytesOf(askValues(turn)))), turn);
    const Bytes answer =
        bytesOf(encodeValues({.turn = turn, .voltage = 241, .tachometer = -123456, .fault = 2, .id = 77}));
    const auto values = parseValues(answer);
    ASSERT_TRUE(values);
    EXPECT_EQ(values->turn, turn);
    EXPECT_EQ(values->voltage, 241);
    EXPECT_EQ(values->tachometer, -123456);
    EXPECT_EQ(values->fault, 2);
    EXPECT_EQ(values->id, 77);
  }
  EXPECT_FALSE(parseValues(bytesOf(encodeVersion())));
  EXPECT_FALSE(parseValues(kSpeed));
  EXPECT_TRUE(isVersion(bytesOf(encodeVersion())));
  EXPECT_FALSE(isVersion(kAskVersion)) << "an echo of the question";
}

TEST(VescPackets, AreRefusedWithOneByteDamagedAndReadBehindIt) {
  const Bytes good = bytesOf(encodeValues({.tachometer = 5, .id = 1}));
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes damaged = good;
    damaged[i] ^= 0x10;
    const auto size = Format::sizeOf(damaged);
    EXPECT_FALSE(size && *size == good.size() && Format::isGood(damaged)) << i;
  }
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    Decoder decoder;
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    for (int k = 0; k < 8; ++k) bytes.insert(bytes.end(), good.begin(), good.end());
    int read = 0;
    for (const std::uint8_t byte : bytes)
      decoder.push(byte, [&](std::span<const std::uint8_t> frame) { read += parseValues(frame) ? 1 : 0; });
    EXPECT_GE(read, 1) << "a false head holds at most 133 bytes";
  }
}

}  // namespace
}  // namespace slam::vesc::vesc_packets_test
