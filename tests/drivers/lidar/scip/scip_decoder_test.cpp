// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scip/scip_decoder.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "support/allocations.hpp"

namespace slam::scip_decoder_test {
namespace {

const scip::Parameters kUnit{.model = "URG-04LX",
                             .steps_per_turn = 1024,
                             .first = 44,
                             .last = 725,
                             .front = 384,
                             .least_mm = 20,
                             .most_mm = 5600,
                             .turns_per_minute = 600};
const std::string kCommand = scip::scanCommand(kUnit);

std::string withSum(const std::string& line) { return line + scip::sumOf(line) + "\n"; }

/// @param range [mm] of step i
template <typename Range>
std::string scanOf(std::uint32_t stamp, Range&& range) {
  std::string data, text = kCommand + "\n99b\n" + withSum(scip::encode(stamp, 4));
  for (int i = 0; i < kUnit.steps(); ++i) data += scip::encode(static_cast<std::uint32_t>(range(i)), 3);
  for (std::size_t at = 0; at < data.size(); at += 64) text += withSum(data.substr(at, 64));
  return text + "\n";
}
std::string scanOf(std::uint32_t stamp) {
  return scanOf(stamp, [](int i) { return 1000 + i; });
}

struct Fed {
  std::vector<TimedNode> nodes;
  std::vector<int> lost;  // before each scan
  int turns = 0;
};
Fed feed(ScipDecoder& decoder, const std::string& text) {
  Fed fed;
  for (const char c : text) {
    const std::size_t before = fed.nodes.size();
    decoder.push(static_cast<std::uint8_t>(c), fed.nodes);
    if (fed.nodes.size() > before) fed.lost.push_back(decoder.lost());
    fed.turns += decoder.endsTurn();
  }
  return fed;
}

TEST(ScipDecoder, GivesTheRangesOfAScanWithItsAnglesCounterClockwise) {
  ScipDecoder decoder(kUnit, kCommand, 1e-6);
  const Fed fed = feed(decoder, kCommand + "\n00P\n\n" + scanOf(100));
  ASSERT_EQ(fed.nodes.size(), 682U);
  EXPECT_EQ(fed.turns, 1);
  EXPECT_EQ(decoder.rejects(), 0);
  for (int i = 0; i < 682; ++i) {
    const TimedNode& timed = fed.nodes[static_cast<std::size_t>(i)];
    EXPECT_EQ(timed.node.distance_q2, 4U * static_cast<unsigned>(1000 + i));
    EXPECT_EQ(timed.node.angle_q6, kUnit.angleQ6(44 + i));
    EXPECT_EQ(timed.node.start, i == 0);
    EXPECT_NEAR(timed.age, (681 - i) * 0.1 / 1024 + 1e-6 * static_cast<double>(scanOf(100).size()), 1e-9);
  }
}

TEST(ScipDecoder, TakesCodesForNoEcho) {
  ScipDecoder decoder(kUnit, kCommand, 1e-6);
  constexpr std::array kRanges = {0, 19, 20, 5600, 5601, 262143};
  const Fed fed =
      feed(decoder, scanOf(100, [&](int i) { return kRanges[std::min<std::size_t>(i, kRanges.size() - 1)]; }));
  ASSERT_EQ(fed.nodes.size(), 682U);
  constexpr std::array kSeen = {0, 0, 20, 5600, 0, 0};
  for (std::size_t i = 0; i < kSeen.size(); ++i) EXPECT_EQ(fed.nodes[i].node.distance_q2, 4U * kSeen[i]) << i;
}

TEST(ScipDecoder, CountsTheScansThatAreMissingByTheUnitsStamps) {
  ScipDecoder decoder(kUnit, kCommand, 1e-6);
  constexpr int kGap = 1024 - 682;
  const std::uint32_t wrap = scip::kStampWrap;
  const Fed fed = feed(decoder, scanOf(wrap - 250) + scanOf(wrap - 150) + scanOf(wrap - 50) + scanOf(50) + scanOf(350) +
                                    scanOf(350) + scanOf(8000000));
  EXPECT_EQ(fed.lost, (std::vector<int>{0, kGap, kGap, kGap, kGap + 2048, kGap, kGap}));
}

TEST(ScipDecoder, LeavesADamagedScanOutWholeAndReadsTheNext) {
  const std::string good = scanOf(100);
  std::mt19937 random(3);
  for (int kind = 0; kind < 3; ++kind) {
    for (std::size_t at = 0; at < good.size(); at += 1 + random() % 5) {
      const bool counts_on = kind == 0 && (at == kCommand.size() - 2 || at == kCommand.size() - 1);
      if (counts_on || (kind == 2 && at == 0)) continue;  // neither belongs to the scan
      ScipDecoder decoder(kUnit, kCommand, 1e-6);
      std::string bad = good;
      if (kind == 0) bad[at] = static_cast<char>(bad[at] ^ (1 << random() % 6));
      if (kind == 1) bad.erase(at, 1);
      if (kind == 2) bad.insert(at, 1, static_cast<char>(0x30 + random() % 0x40));
      const Fed fed = feed(decoder, good + bad + good + good);
      const std::size_t scans = fed.nodes.size() / 682;
      // What damages the end costs the scan behind it at most.
      EXPECT_TRUE(scans == 3 || (at + 2 >= good.size() && scans == 2)) << kind << " " << at << " " << scans;
      EXPECT_EQ(fed.nodes.size() % 682, 0U);
      EXPECT_GE(decoder.rejects(), 1) << kind << " " << at;
    }
  }
}

TEST(ScipDecoder, BoundsWhatItKeeps) {
  ScipDecoder decoder(kUnit, kCommand, 1e-6);
  feed(decoder, scanOf(100));
  std::string text = kCommand + "\n99b\n" + withSum(scip::encode(200, 4));
  for (int i = 0; i < 1000; ++i) text += withSum(std::string(64, '0'));  // a scan that does not end
  text += std::string(100000, 'x');                                      // a line that does not end
  std::vector<TimedNode> nodes;
  nodes.reserve(1000);
  EXPECT_EQ(test::allocationsDuring([&] {
              for (const char c : text) decoder.push(static_cast<std::uint8_t>(c), nodes);
            }),
            0U);
  EXPECT_TRUE(nodes.empty());
  EXPECT_GE(decoder.rejects(), 1);
  EXPECT_EQ(feed(decoder, "\n\n" + scanOf(300)).turns, 1);
}

}  // namespace
}  // namespace slam::scip_decoder_test
