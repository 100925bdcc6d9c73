// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/fragment_assembler.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::fragment_assembler_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
const auto kAll = [](std::string_view) { return true; };

Bytes messageOf(std::size_t size, std::uint8_t seed) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(seed + 31 * i);
  return bytes;
}

/// A message in parts as liblcm makes them.
std::vector<Fragment> partsOf(const Bytes& message, std::uint32_t sequence, std::size_t part,
                              std::string_view channel) {
  std::vector<Fragment> parts;
  const auto count = static_cast<std::uint16_t>((message.size() + part - 1) / part);
  for (std::uint16_t i = 0; i < count; ++i) {
    const std::size_t at = i * part;
    parts.push_back({sequence, static_cast<std::uint32_t>(message.size()), static_cast<std::uint32_t>(at), i, count,
                     i == 0 ? channel : std::string_view(),
                     std::span(message).subspan(at, std::min(part, message.size() - at))});
  }
  return parts;
}

TEST(FragmentAssembler, PutsMessagesOfTwoSendersTogether) {
  FragmentAssembler assembler;
  const Bytes a = messageOf(70'000, 1), b = messageOf(150'000, 2);
  const auto of_a = partsOf(a, 7, 65'000, "SLAM_SCAN"), of_b = partsOf(b, 1, 65'000, "SLAM_SCAN");
  EXPECT_FALSE(assembler.take(of_a[0], kAll));
  EXPECT_FALSE(assembler.take(of_b[0], kAll));
  const auto first = assembler.take(of_a[1], kAll);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->channel, "SLAM_SCAN");
  EXPECT_EQ(Bytes(first->data.begin(), first->data.end()), a);
  EXPECT_FALSE(assembler.take(of_b[1], kAll));
  const auto second = assembler.take(of_b[2], kAll);
  ASSERT_TRUE(second);
  EXPECT_EQ(Bytes(second->data.begin(), second->data.end()), b);
  EXPECT_FALSE(assembler.take(of_b[2], kAll)) << "it is complete";
}

TEST(FragmentAssembler, LeavesOutAMessageOfWhichAPartIsLost) {
  FragmentAssembler assembler;
  const Bytes message = messageOf(200'000, 1);
  auto parts = partsOf(message, 7, 65'000, "SLAM_SCAN");
  assembler.take(parts[0], kAll);
  for (std::size_t i = 2; i < parts.size(); ++i) EXPECT_FALSE(assembler.take(parts[i], kAll));
  std::optional<FragmentAssembler::Whole> whole;
  for (Fragment& part : parts) {
    part.sequence = 8;
    whole = assembler.take(part, kAll);
  }
  ASSERT_TRUE(whole) << "the next one is good";
  EXPECT_EQ(whole->data.size(), message.size());
}

TEST(FragmentAssembler, KeepsNothingOfChannelsThatNobodyWants) {
  FragmentAssembler assembler;
  const Bytes message = messageOf(70'000, 1);
  for (const Fragment& part : partsOf(message, 7, 65'000, "CAMERA"))
    EXPECT_FALSE(assembler.take(part, [](std::string_view channel) { return channel == "SLAM_SCAN"; }));
}

TEST(FragmentAssembler, AcceptsNoLength) {
  FragmentAssembler assembler;
  const Bytes payload = messageOf(100, 1);
  EXPECT_FALSE(assembler.take({7, 1000, 0xFFFFFFF0, 0, 2, "SLAM_SCAN", payload}, kAll)) << "offset and size pass 2^32";
  EXPECT_FALSE(assembler.take({8, 0xFFFFFFFF, 0, 0, 2, "SLAM_SCAN", payload}, kAll));
  EXPECT_FALSE(assembler.take({9, 50, 0, 0, 2, "SLAM_SCAN", payload}, kAll)) << "more than it is to have";
  for (const std::uint16_t parts : {std::uint16_t{0}, std::uint16_t{1}})
    EXPECT_FALSE(assembler.take({10, 100, 0, 0, parts, "SLAM_SCAN", payload}, kAll)) << "no part of several";
  std::mt19937 random(1);
  const auto any = [&](std::uint32_t below) { return static_cast<std::uint32_t>(random() % below); };
  int whole = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto number = static_cast<std::uint16_t>(any(4));
    const Fragment part{any(3),
                        100 * any(4),
                        100 * any(4),
                        number,
                        static_cast<std::uint16_t>(any(4)),
                        number == 0 ? "SLAM_SCAN" : "",
                        std::span(payload).first(100 * any(2))};
    if (const auto done = assembler.take(part, kAll)) {
      ++whole;
      ASSERT_LE(done->data.size(), 300U);
      ASSERT_EQ(done->channel, "SLAM_SCAN");
    }
  }
  EXPECT_GT(whole, 10) << "or this test shows nothing";
}

TEST(FragmentAssembler, TakesNoPartThatBelongsElsewhere) {
  const Bytes message = messageOf(150'000, 1);
  for (const std::int32_t aside : {0, -1, 1, -65'000}) {
    FragmentAssembler assembler;
    auto parts = partsOf(message, 7, 65'000, "SLAM_SCAN");
    parts[1].offset += static_cast<std::uint32_t>(aside);
    std::optional<FragmentAssembler::Whole> whole;
    for (const Fragment& part : parts) whole = assembler.take(part, kAll);
    EXPECT_EQ(whole.has_value(), aside == 0) << aside;
  }
}

}  // namespace
}  // namespace slam::fragment_assembler_test
