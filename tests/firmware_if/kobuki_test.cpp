// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/kobuki.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

namespace slam::kobuki::kobuki_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const Outgoing& out) { return {out.bytes().begin(), out.bytes().end()}; }

std::vector<Bytes> framesIn(const Bytes& bytes, Decoder& decoder) {
  std::vector<Bytes> frames;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) { frames.emplace_back(frame.begin(), frame.end()); });
  return frames;
}

// Computed by the published description: stamp 1000, counts 100 and 65530, 16.0 V, 12.34 degrees, -0.50 degrees/s.
const Bytes kFeedback{0xAA, 0x55, 0x1A, 0x01, 0x0F, 0xE8, 0x03, 0x00, 0x00, 0x00, 0x64, 0x00, 0xFA, 0xFF, 0x00,
                      0x00, 0x00, 0x00, 0xA0, 0x00, 0x04, 0x07, 0xD2, 0x04, 0xCE, 0xFF, 0x00, 0x00, 0x00, 0xDA};

TEST(KobukiFeedback, IsReadAsItIsDescribed) {
  Decoder decoder;
  const auto frames = framesIn(kFeedback, decoder);
  ASSERT_EQ(frames.size(), 1U);
  const auto feedback = parseFeedback(frames[0]);
  ASSERT_TRUE(feedback);
  EXPECT_EQ(feedback->stamp, 1000);
  EXPECT_EQ(feedback->counts, (std::array<std::uint16_t, 2>{100, 65530}));
  EXPECT_NEAR(feedback->battery, 16.0, 1e-9);
  EXPECT_EQ(feedback->turn_rate, -50);
  EXPECT_FALSE(feedback->dropped || feedback->bumped || feedback->cliff);
}

// A full frame of a base is 4Dh long and begins with the core data, as its maker's help page quotes one.
TEST(KobukiFeedback, IsFoundAmongOtherSubPayloads) {
  Bytes payload(kFeedback.begin() + 3, kFeedback.end() - 1);
  for (const auto& [id, size] : {std::pair{3, 3}, {5, 6}, {6, 2}, {13, 14}, {16, 16}}) {
    payload.push_back(static_cast<std::uint8_t>(id));
    payload.push_back(static_cast<std::uint8_t>(size));
    payload.insert(payload.end(), static_cast<std::size_t>(size), 0x55);
  }
  payload.resize(0x4D);
  payload[payload.size() - 1] = 0;
  Bytes frame{0xAA, 0x55, 0x4D};
  frame.insert(frame.end(), payload.begin(), payload.end());
  std::uint8_t sum = 0;
  for (std::size_t i = 2; i < frame.size(); ++i) sum ^= frame[i];
  frame.push_back(sum);
  Decoder decoder;
  ASSERT_EQ(framesIn(frame, decoder).size(), 1U);
  EXPECT_EQ(frame[3], 0x01);
  EXPECT_EQ(frame[4], 0x0F);
}

TEST(KobukiFeedback, IsRefusedWhereASubPayloadEndsBehindTheFrame) {
  Bytes frame = kFeedback;
  frame[4] = 0xFF;
  EXPECT_FALSE(parseFeedback(frame));
  frame = kFeedback;
  frame[21] = 0x08;  // the inertia data
  EXPECT_FALSE(parseFeedback(frame));
  EXPECT_FALSE(parseFeedback(Bytes{0xAA, 0x55, 0x04, 0x09, 0x02, 0x0B, 0x00, 0x04})) << "no core data";
}

TEST(KobukiFeedback, GoesThereAndBackAndIsReadBehindDamage) {
  const Feedback feedback{.stamp = 65535, .bumped = true, .dropped = true, .counts = {0x55AA, 7}, .battery = 14.3};
  const Bytes good = bytesOf(encodeFeedback(feedback));
  const auto read = parseFeedback(good);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->bumped && read->dropped);
  EXPECT_EQ(read->counts, feedback.counts);
  EXPECT_NEAR(read->battery, 14.3, 1e-9);
  EXPECT_FALSE(read->turn_rate);
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    Decoder decoder;
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    for (int k = 0; k < 14; ++k) bytes.insert(bytes.end(), good.begin(), good.end());
    EXPECT_GE(framesIn(bytes, decoder).size(), 2U) << "a false head holds at most 259 bytes";
  }
}

// Computed by the published description and the formula of its maker's driver.
TEST(KobukiCommands, AreThoseOfTheDescription) {
  EXPECT_EQ(bytesOf(encode(commandOf(0.0, 0.0))), (Bytes{0xAA, 0x55, 0x06, 0x01, 0x04, 0, 0, 0, 0, 0x03}));
  EXPECT_EQ(bytesOf(encode(commandOf(0.2, 0.0))), (Bytes{0xAA, 0x55, 0x06, 0x01, 0x04, 0xC8, 0, 0, 0, 0xCB}));
  EXPECT_EQ(bytesOf(encode(commandOf(0.0, 1.0))), (Bytes{0xAA, 0x55, 0x06, 0x01, 0x04, 0x73, 0, 0x01, 0, 0x71}));
  EXPECT_EQ(commandOf(0.0, -1.0), (BaseCommand{-115, 1}));
}

TEST(KobukiCommands, MeanTheTwistThatTheyWereMadeOf) {
  for (const double speed : {-0.5, -0.1, -0.01, 0.0, 0.02, 0.3}) {
    for (const double turn_rate : {-2.0, -0.3, -0.02, 0.0, 0.05, 1.5}) {
      const BaseCommand command = commandOf(speed, turn_rate);
      const auto [v, w] = twistOf(*parseCommand(encode(command).bytes()));
      EXPECT_NEAR(v, speed, 0.006) << speed << " " << turn_rate;
      EXPECT_NEAR(w, turn_rate, 0.02) << speed << " " << turn_rate;
    }
  }
  EXPECT_FALSE(parseCommand(kFeedback));
}

}  // namespace
}  // namespace slam::kobuki::kobuki_test
