// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/create_oi.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

namespace slam::create_oi::create_oi_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const Outgoing& out) { return {out.bytes().begin(), out.bytes().end()}; }

std::vector<Bytes> framesIn(const Bytes& bytes, StreamDecoder& decoder) {
  std::vector<Bytes> frames;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) { frames.emplace_back(frame.begin(), frame.end()); });
  return frames;
}

// The first frame is the example of the maker's manual, recomputed; the second is computed.
TEST(CreateStream, HasTheChecksumOfTheManualsExample) {
  StreamDecoder decoder;
  const Bytes manual{0x13, 0x05, 0x1D, 0x02, 0x25, 0x0D, 0x00, 0x97};
  const Bytes counts{0x13, 0x06, 0x2B, 0xFF, 0xFA, 0x2C, 0x00, 0x0C, 0x8B};
  EXPECT_THAT(framesIn(manual, decoder), testing::ElementsAre(manual));
  EXPECT_THAT(framesIn(counts, decoder), testing::ElementsAre(counts));
  EXPECT_FALSE(parseStream(manual)) << "other packets than those that are asked for";
  EXPECT_EQ(decoder.damaged(), 0U);
}

// Computed: direct right 200, left -100 mm/s.
TEST(CreateCommands, AreThoseOfTheManual) {
  EXPECT_EQ(bytesOf(driveDirect(-100, 200)), (Bytes{0x91, 0x00, 0xC8, 0xFF, 0x9C}));
  EXPECT_EQ(bytesOf(driveDirect(9999, -9999)), (Bytes{0x91, 0xFE, 0x0C, 0x01, 0xF4})) << "500 mm/s at most";
  EXPECT_EQ(bytesOf(start()), Bytes{128});
  EXPECT_EQ(bytesOf(stop()), Bytes{173});
  EXPECT_EQ(bytesOf(enterSafe()), Bytes{131});
  EXPECT_EQ(bytesOf(askForStream()), (Bytes{148, 8, 7, 22, 34, 35, 41, 42, 43, 44}));
  EXPECT_EQ(bytesOf(pauseStream()), (Bytes{150, 0}));
}

TEST(CreateStream, GoesThereAndBack) {
  const Sensors sensors{.dropped = true,
                        .voltage = 14123,
                        .plugged_in = true,
                        .mode = Mode::kSafe,
                        .requested = {-200, 300},
                        .counts = {65530, 12}};
  const auto read = parseStream(encodeStream(sensors).bytes());
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->dropped && read->plugged_in);
  EXPECT_FALSE(read->bumped);
  EXPECT_EQ(read->voltage, 14123);
  EXPECT_EQ(read->mode, Mode::kSafe);
  EXPECT_EQ(read->requested, sensors.requested);
  EXPECT_EQ(read->counts, sensors.counts);
}

TEST(CreateStream, IsReadBehindDamage) {
  const Bytes good = bytesOf(encodeStream({.mode = Mode::kPassive, .counts = {0x1313, 0x1305}}));
  for (std::size_t lost = 0; lost < good.size(); ++lost) {
    StreamDecoder decoder;
    Bytes bytes = good;
    bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(lost));
    for (int i = 0; i < 6; ++i) bytes.insert(bytes.end(), good.begin(), good.end());
    std::size_t read = 0;
    for (const Bytes& frame : framesIn(bytes, decoder)) read += parseStream(frame) ? 1 : 0;
    EXPECT_GE(read, 3U) << lost;
  }
}

TEST(CreateStream, RefusesAModeThatThereIsNot) {
  Bytes frame = bytesOf(encodeStream({.mode = Mode::kFull}));
  ASSERT_TRUE(parseStream(frame));
  frame[10] = 4;  // behind 13, n, 07 x, 16 xx, 22 x, 23
  EXPECT_FALSE(parseStream(frame));
}

}  // namespace
}  // namespace slam::create_oi::create_oi_test
