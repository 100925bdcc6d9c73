// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/cola/cola_decoder.hpp"

#include <array>
#include <cstdio>
#include <gtest/gtest.h>

#include "support/allocations.hpp"

namespace slam::cola_decoder_test {
namespace {

std::string scanText(std::uint32_t us, int beams = 5, const std::string& scale = "3F800000") {
  std::array<char, 256> head{};
  std::snprintf(
      head.data(), head.size(),
      "sSN LMDscandata 1 1 89A27F 0 0 343 347 %X 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 %s 00000000 186A0 1388 %X", us,
      scale.c_str(), static_cast<unsigned>(beams));
  std::string text = head.data();
  constexpr std::array kValues = {"0", "3", "9", "A", "FFFF"};
  for (int i = 0; i < beams; ++i) text += std::string(" ") + kValues[static_cast<std::size_t>(i) % kValues.size()];
  return text + " 0 0 0 0 0 0";
}

ColaDecoder decoderFor(const std::string& text) { return {*cola::parseScan(text), 0.0}; }

struct Fed {
  std::vector<TimedNode> nodes;
  std::vector<int> lost;  // before each scan
};
Fed feed(ColaDecoder& decoder, const std::string& bytes) {
  Fed fed;
  for (const char c : bytes) {
    const std::size_t before = fed.nodes.size();
    decoder.push(static_cast<std::uint8_t>(c), fed.nodes);
    if (fed.nodes.size() > before) fed.lost.push_back(decoder.lost());
    EXPECT_EQ(decoder.endsTurn(), fed.nodes.size() > before);
  }
  return fed;
}

TEST(ColaDecoder, GivesRangesAndTakesCodesForNoEcho) {
  ColaDecoder decoder = decoderFor(scanText(0));
  const Fed fed = feed(decoder, cola::telegram("sEA LMDscandata 1") + cola::telegram(scanText(100)));
  ASSERT_EQ(fed.nodes.size(), 5U);
  constexpr std::array<unsigned, 5> kSeen = {0, 0, 0, 10, 65535};
  for (std::size_t i = 0; i < kSeen.size(); ++i) {
    EXPECT_EQ(fed.nodes[i].node.distance_q2, 4 * kSeen[i]) << i;
    EXPECT_EQ(fed.nodes[i].node.start, i == 0);
    EXPECT_NEAR(fed.nodes[i].age, 0.02 / 720 * static_cast<double>(4 - i), 1e-12);
  }
  EXPECT_EQ(decoder.rejects(), 1) << "the other telegram";
  ColaDecoder doubled = decoderFor(scanText(0, 5, "40000000"));
  EXPECT_EQ(feed(doubled, cola::telegram(scanText(0, 5, "40000000"))).nodes[3].node.distance_q2, 80U);
}

TEST(ColaDecoder, CountsTheScansThatAreMissingByTheUnitsClock) {
  ColaDecoder decoder = decoderFor(scanText(0));
  std::string bytes;
  for (const std::uint32_t us : {0xFFFFF000U, 0x00003E20U, 0x0000D0E0U, 0x0000D0E0U})
    bytes += cola::telegram(scanText(us));
  EXPECT_EQ(feed(decoder, bytes).lost, (std::vector<int>{0, 715, 715 + 720, 715}));
}

TEST(ColaDecoder, LeavesOutAScanOfOtherBeamsAndOneThatIsCutShort) {
  ColaDecoder decoder = decoderFor(scanText(0));
  const std::string good = cola::telegram(scanText(100)), text = scanText(100);
  EXPECT_TRUE(feed(decoder, cola::telegram(scanText(100, 6))).nodes.empty());
  EXPECT_TRUE(feed(decoder, cola::telegram(text.substr(0, text.find(" FFFF")))).nodes.empty());
  EXPECT_TRUE(feed(decoder, cola::telegram(text.substr(0, text.find(" FFFF")) + " 1FFFF")).nodes.empty());
  EXPECT_TRUE(feed(decoder, good.substr(0, good.size() - 1)).nodes.empty());
  EXPECT_EQ(decoder.rejects(), 3);
  EXPECT_EQ(feed(decoder, good).nodes.size(), 5U) << "the end of the one before is missing";
  EXPECT_EQ(decoder.rejects(), 4);
}

TEST(ColaDecoder, BoundsWhatItKeeps) {
  ColaDecoder decoder = decoderFor(scanText(0));
  const std::string bytes = "\x02" + std::string(10 * cola::kLongest, '1');
  std::vector<TimedNode> nodes;
  nodes.reserve(8);
  EXPECT_EQ(test::allocationsDuring([&] {
              for (const char c : bytes) decoder.push(static_cast<std::uint8_t>(c), nodes);
            }),
            0U);
  EXPECT_EQ(decoder.rejects(), 1);
  EXPECT_EQ(feed(decoder, cola::telegram(scanText(1))).nodes.size(), 5U);
}

}  // namespace
}  // namespace slam::cola_decoder_test
