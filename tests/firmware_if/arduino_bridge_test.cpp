// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/arduino_bridge.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <string>

namespace slam::arduino_bridge::arduino_bridge_test {
namespace {

std::string text(const Outgoing& out) { return {out.bytes().begin(), out.bytes().end()}; }

std::optional<Answer> push(LineDecoder& decoder, const std::string& line) {
  std::optional<Answer> answer;
  for (const char c : line) {
    if (const auto one = decoder.push(static_cast<std::uint8_t>(c))) answer = one;
  }
  return answer;
}

// The exchanges of the published sketch: e is answered with 100 -5, m with OK.
TEST(ArduinoBridge, SendsWhatThePublishedSketchReads) {
  EXPECT_EQ(text(askCounts()), "\x65\x0D");
  EXPECT_EQ(text(encodeSpeeds(20, -20)), "\x6D\x20\x32\x30\x20\x2D\x32\x30\x0D");
  EXPECT_EQ(text(askBaudRate()), "b\r");
  LineDecoder decoder;
  const auto counts = push(decoder, "\x31\x30\x30\x20\x2D\x35\x0D\x0A");
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->kind, Answer::kCounts);
  EXPECT_EQ(counts->counts, (std::array<std::int32_t, 2>{100, -5}));
  EXPECT_EQ(push(decoder, "\x4F\x4B\x0D\x0A")->kind, Answer::kDone);
  EXPECT_EQ(push(decoder, "57600\r\n")->kind, Answer::kNumber);
  EXPECT_EQ(push(decoder, "Invalid Command\r\n")->kind, Answer::kRefused);
  EXPECT_EQ(decoder.damaged(), 0U);
}

TEST(ArduinoBridge, RefusesWhatIsNoAnswer) {
  for (const char* line : {"", " ", "1 ", " 1 2", "1  2", "1 2 3", "1 2x", "-", "+1 2", "1.5 2", "99999999999 1",
                           "1 -2147483649", "OK ", "ok", "0x1 2"})
    EXPECT_FALSE(parseLine(line)) << line;
  EXPECT_EQ(parseLine("2147483647 -2147483648")->counts,
            (std::array{std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()}));
}

TEST(ArduinoBridge, GoesOnBehindALineThatHasNoEnd) {
  LineDecoder decoder;
  std::string endless(1000, '7');
  endless.append("\r\n");
  EXPECT_FALSE(push(decoder, endless));
  EXPECT_EQ(decoder.damaged(), 1U);
  EXPECT_TRUE(push(decoder, "1 2\r\n"));
  EXPECT_FALSE(push(decoder, "12"));
  decoder.reset();
  EXPECT_EQ(push(decoder, "3 4\r")->counts[0], 3) << "half a line must not hold the next answer back";
}

TEST(ArduinoBridge, LimitsSpeeds) {
  EXPECT_EQ(text(encodeSpeeds(std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min())),
            "m 32767 -32767\r");
  EXPECT_EQ(text(encodeSpeeds(0, 0)), "m 0 0\r");
}

}  // namespace
}  // namespace slam::arduino_bridge::arduino_bridge_test
