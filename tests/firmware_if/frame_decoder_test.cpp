// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/frame_decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

#include "firmware_if/outgoing.hpp"

namespace slam::frame_decoder_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// 7F, size of all, content, sum of the content.
struct Format {
  static constexpr std::size_t kLongest = 9;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes) {
    if (bytes[0] != 0x7F) return 0;
    return bytes.size() < 2 ? std::nullopt : std::optional<std::size_t>(bytes[1]);
  }
  static bool isGood(std::span<const std::uint8_t> frame) {
    std::uint8_t sum = 0;
    for (const std::uint8_t byte : frame.subspan(2, frame.size() - 3)) sum = static_cast<std::uint8_t>(sum + byte);
    return sum == frame.back();
  }
};

std::vector<Bytes> framesIn(FrameDecoder<Format>& decoder, const Bytes& bytes) {
  std::vector<Bytes> frames;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) { frames.emplace_back(frame.begin(), frame.end()); });
  return frames;
}

TEST(FrameDecoder, FindsFramesInsideThoseThatAreDamaged) {
  FrameDecoder<Format> decoder;
  const Bytes good{0x7F, 0x05, 1, 2, 3};
  EXPECT_THAT(framesIn(decoder, {9, 8, 0x7F, 0x05, 1, 2, 3}), testing::ElementsAre(good));
  EXPECT_EQ(decoder.skipped(), 2U);
  EXPECT_THAT(framesIn(decoder, {0x7F, 0x09, 0x7F, 0x05, 1, 2, 3, 0, 0}), testing::ElementsAre(good));
  EXPECT_EQ(decoder.damaged(), 1U);
  EXPECT_THAT(framesIn(decoder, {0x7F, 0x7F, 0x05, 1, 2, 3}), testing::ElementsAre(good)) << "too long a frame is none";
  framesIn(decoder, {0x7F, 0x09, 1});
  decoder.reset();
  EXPECT_THAT(framesIn(decoder, good), testing::ElementsAre(good));
}

TEST(Outgoing, HoldsBytesInBothOrdersAndNoMoreThanItCan) {
  Outgoing out{1, 2};
  out.addBig<2>(0x0304);
  out.addLittle<4>(0x08070605);
  EXPECT_THAT(out.bytes(), testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  for (int i = 0; i < 1000; ++i) out.addByte(9);
  EXPECT_EQ(out.size(), Outgoing::kMost);
  EXPECT_TRUE(Outgoing().empty());
}

}  // namespace
}  // namespace slam::frame_decoder_test
