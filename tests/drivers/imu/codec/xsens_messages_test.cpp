// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/codec/xsens_messages.hpp"

#include <gtest/gtest.h>
#include <sstream>
#include <string>

namespace slam::xsens::xsens_messages_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const std::string& hexadecimal) {
  std::istringstream in(hexadecimal);
  Bytes bytes;
  for (std::string byte; in >> byte;) bytes.push_back(static_cast<std::uint8_t>(std::stoi(byte, nullptr, 16)));
  return bytes;
}

/// Messages in a stream, with copies of their data.
std::vector<std::pair<std::uint8_t, Bytes>> messagesIn(const Bytes& bytes) {
  Decoder decoder;
  std::vector<std::pair<std::uint8_t, Bytes>> messages;
  for (const std::uint8_t byte : bytes) {
    decoder.push(byte, [&](std::span<const std::uint8_t> whole) {
      const Message message = parse(whole);
      messages.push_back({message.id, Bytes(message.data.begin(), message.data.end())});
    });
  }
  return messages;
}

TEST(XsensMessages, OfARealMtiAreReadAsItsMakersProgramDoes) {
  // Data of an MTi-300-2A5G4, firmware 1.8.2, recorded and decoded with MT Manager ("XSens Golden Packets").
  const Bytes data = bytesOf(
      "10 20 02 A6 55 10 60 04 00 57 47 2E 20 10 10 3F 7F 7D C4 BC 10 10 7D 3B A1 57 70 BD 7E C6 56 40 20 0C BD A2 1A "
      "F8 "
      "BE 2A 8E 96 41 1D 27 A2 40 10 0C B9 4F C8 00 B9 DA 24 00 3C C9 28 80 40 30 0C 3C 02 C8 9C 3C 35 F6 C8 3C DB 0C "
      "00 "
      "80 20 0C BB B1 7D 81 BB 96 32 00 3C 01 E8 41 80 30 10 3F 80 00 00 B6 E3 30 01 B6 C0 40 00 37 26 48 00 C0 20 0C "
      "BE "
      "99 9C 24 3F B6 1B 56 3F 16 6A EB 30 10 04 00 01 86 DE E0 20 04 00 40 00 03");
  ASSERT_EQ(data.size(), 139U);
  Bytes stream;
  encode(Message{kData2, data}, stream);
  const auto messages = messagesIn(stream);
  ASSERT_EQ(messages.size(), 1U);
  ASSERT_EQ(messages[0].second, data);
  const auto motion = parseMotion(messages[0].second);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->counter, 42581);
  EXPECT_EQ(motion->ticks, 5719854U);
  ASSERT_TRUE(motion->turn_rate && motion->acceleration);
  EXPECT_NEAR((*motion->turn_rate)[0], -0.00541657, 1e-8);
  EXPECT_NEAR((*motion->turn_rate)[2], 0.00792891, 1e-8);
  EXPECT_NEAR((*motion->acceleration)[1], -0.16655955, 1e-8);
  EXPECT_NEAR((*motion->acceleration)[2], 9.82217598, 1e-6);
}

TEST(XsensMessages, OfARealMtiWithItsOrientationAloneHaveNoTurnRate) {
  const auto motion =
      parseMotion(bytesOf("10 20 02 46 82 10 60 04 01 C4 FC 3E 20 10 10 3F 71 CE 6C BE A5 6B CF 3C 61 3B D8 BD 69 1D "
                          "25 E0 20 04 00 40 00 03"));
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->ticks, 29686846U);
  EXPECT_FALSE(motion->turn_rate || motion->acceleration);
}

TEST(XsensMessages, HaveTheMakersSums) {
  for (const auto& [id, text] : {std::pair(kGoToMeasurement, "FA FF 10 00 F1"), {kGoToConfig, "FA FF 30 00 D1"}}) {
    const Outgoing sent = encode(id);
    EXPECT_EQ(Bytes(sent.bytes().begin(), sent.bytes().end()), bytesOf(text));
    EXPECT_EQ(messagesIn(bytesOf(text)).at(0).first, id);
  }
  const auto messages = messagesIn(
      bytesOf("FA FF 36 1B 10 20 02 00 07 10 60 04 00 BC 61 4E 80 20 0C 00 00 00 00 00 00 00 00 3F 00 00 00 AD"));
  ASSERT_EQ(messages.size(), 1U);
  const auto motion = parseMotion(messages[0].second);
  ASSERT_TRUE(motion && motion->turn_rate);
  EXPECT_EQ(motion->counter, 7);
  EXPECT_EQ(motion->ticks, 12345678U);
  EXPECT_EQ((*motion->turn_rate)[2], 0.5);
}

TEST(XsensMessages, HaveNumbersOfFourKinds) {
  const std::array<double, 3> expected{1.5, -2.25, 0.5};
  const auto rateOf = [](const std::string& text) { return parseMotion(bytesOf(text))->turn_rate; };
  EXPECT_EQ(rateOf("80 20 0C 3F C0 00 00 C0 10 00 00 3F 00 00 00"), expected);
  EXPECT_EQ(rateOf("80 21 0C 00 18 00 00 FF DC 00 00 00 08 00 00"), expected);
  EXPECT_EQ(rateOf("80 22 12 80 00 00 00 00 01 C0 00 00 00 FF FD 80 00 00 00 00 00"), expected);
  EXPECT_EQ(rateOf("80 23 18 3F F8 00 00 00 00 00 00 C0 02 00 00 00 00 00 00 3F E0 00 00 00 00 00 00"), expected);
  EXPECT_EQ(rateOf("80 24 0C 3F C0 00 00 C0 10 00 00 3F 00 00 00"), expected) << "in other axes of the earth";
  EXPECT_FALSE(rateOf("80 23 0C 3F C0 00 00 C0 10 00 00 3F 00 00 00")) << "too short for doubles";
}

TEST(XsensMessages, MayBeLong) {
  for (const std::size_t size : {254U, 255U, 300U, 512U}) {
    Bytes stream;
    encode(Message{kData2, Bytes(size, 0x11)}, stream);
    EXPECT_EQ(stream.size(), size + (size < 255 ? 5 : 7));
    encode(Message{kWakeUp, {}}, stream);
    const auto messages = messagesIn(stream);
    ASSERT_EQ(messages.size(), 2U) << size;
    EXPECT_EQ(messages[0].second.size(), size);
    EXPECT_EQ(messages[1].first, kWakeUp);
  }
}

TEST(XsensMessages, OfLengthsThatCannotBeAreSkipped) {
  Bytes stream = bytesOf("FA FF 36 FF 00 10 FA FF 36 FF FF FF");
  encode(Message{kWakeUp, {}}, stream);
  EXPECT_EQ(messagesIn(stream).size(), 1U);
}

TEST(XsensMessages, AreRefusedWhereTheirBlocksDoNotFit) {
  EXPECT_TRUE(parseMotion({}));
  EXPECT_FALSE(parseMotion(bytesOf("80 20")));
  EXPECT_FALSE(parseMotion(bytesOf("80 20 0C 00 00")));
  EXPECT_FALSE(parseMotion(bytesOf("10 20 02 00 07 80")));
}

}  // namespace
}  // namespace slam::xsens::xsens_messages_test
