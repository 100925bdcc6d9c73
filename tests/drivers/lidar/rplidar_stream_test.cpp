// SPDX-License-Identifier: BSD-3-Clause
// Ultra and dense capsules; standard nodes and express capsules are in rplidar_codec_test.cpp.
#include "drivers/lidar/rplidar_stream.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "support/allocations.hpp"

namespace slam::rplidar::rplidar_stream_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr double kByteTime = 10.0 / 115200.0;  // [s]
constexpr double kSampleTime = 127e-6;         // [s]

using Key = std::pair<int, std::uint32_t>;
Key keyOf(const Node& node) { return {node.angle_q6, node.distance_q2}; }

struct Packets {
  AnswerType type;
  std::size_t size;
  int samples;
  std::vector<Bytes> packets;
  std::vector<Node> nodes;  ///< of all but the last
};

/// So many capsules of 24 degrees; those at `starts` have the S bit.
Packets ultra(int count, const std::set<int>& starts = {0}) {
  Packets result{AnswerType::kUltraCapsules, kUltraCapsuleSize, kUltraSamples, {}, {}};
  std::mt19937 random(5);
  std::vector<UltraCapsule> capsules;
  for (int i = 0; i < count; ++i) {
    UltraCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(i * 24 % 360 * 64), .start = starts.contains(i)};
    for (auto& cabin : capsule.cabins) {
      cabin = {static_cast<std::uint16_t>(200 + random() % 3800), static_cast<std::int16_t>(random() % 200 - 100),
               static_cast<std::int16_t>(random() % 200 - 100)};
    }
    capsules.push_back(capsule);
    const auto bytes = encodeUltraCapsule(capsule);
    result.packets.emplace_back(bytes.begin(), bytes.end());
  }
  for (std::size_t i = 0; i + 1 < capsules.size(); ++i) {
    const auto part = decodeUltra(capsules[i], capsules[i + 1]);
    result.nodes.insert(result.nodes.end(), part.begin(), part.end());
  }
  return result;
}

Packets dense(int count, const std::set<int>& starts = {0}) {
  Packets result{AnswerType::kDenseCapsules, kDenseCapsuleSize, kDenseSamples, {}, {}};
  std::mt19937 random(6);
  for (int i = 0; i < count; ++i) {
    DenseCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(i * 24 % 360 * 64), .start = starts.contains(i)};
    for (auto& distance : capsule.distances_mm) distance = static_cast<std::uint16_t>(150 + random() % 12000);
    const auto bytes = encodeDenseCapsule(capsule);
    result.packets.emplace_back(bytes.begin(), bytes.end());
    if (i + 1 == count) break;
    const auto part = decodeDense(capsule, static_cast<std::uint16_t>((i + 1) * 24 % 360 * 64));
    result.nodes.insert(result.nodes.end(), part.begin(), part.end());
  }
  return result;
}

Packets ultraDense(int count, const std::set<int>& starts) {
  Packets result{AnswerType::kUltraDenseCapsules, kUltraDenseCapsuleSize, kUltraDenseSamples, {}, {}};
  std::mt19937 random(7);
  for (int i = 0; i < count; ++i) {
    UltraDenseCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(i * 24 % 360 * 64),
                              .start = starts.contains(i)};
    for (auto& sample : capsule.samples) sample = decodeUltraDenseSample(static_cast<std::uint32_t>(random()) >> 12);
    const auto bytes = encodeUltraDenseCapsule(capsule);
    result.packets.emplace_back(bytes.begin(), bytes.end());
    if (i + 1 == count) break;
    const auto part = decodeUltraDense(capsule, static_cast<std::uint16_t>((i + 1) * 24 % 360 * 64));
    result.nodes.insert(result.nodes.end(), part.begin(), part.end());
  }
  return result;
}

Bytes streamOf(const std::vector<Bytes>& packets) {
  Bytes stream;
  for (const Bytes& packet : packets) stream.insert(stream.end(), packet.begin(), packet.end());
  return stream;
}

/// @param lost samples, before the node of that place
std::vector<TimedNode> decode(StreamDecoder& decoder, const Bytes& bytes, std::map<std::size_t, int>* lost = nullptr) {
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : bytes) {
    const std::size_t before = nodes.size();
    decoder.push(byte, nodes);
    if (lost != nullptr && nodes.size() > before && decoder.lost() > 0) (*lost)[before] = decoder.lost();
  }
  return nodes;
}

class CapsuleStream : public testing::TestWithParam<Packets (*)(int, const std::set<int>&)> {
 protected:
  Packets make(int count, const std::set<int>& starts = {0}) const { return GetParam()(count, starts); }
  static StreamDecoder decoderOf(const Packets& packets) { return {packets.type, kSampleTime, kByteTime}; }
  /// The nodes of capsules [first, last).
  static std::vector<Key> keys(const Packets& packets, int first, int last) {
    std::vector<Key> result;
    for (int i = first * packets.samples; i < last * packets.samples; ++i) {
      result.push_back(keyOf(packets.nodes[static_cast<std::size_t>(i)]));
    }
    return result;
  }
  static std::vector<Key> keys(const std::vector<TimedNode>& nodes) {
    std::vector<Key> result;
    for (const TimedNode& timed : nodes) result.push_back(keyOf(timed.node));
    return result;
  }
};

TEST_P(CapsuleStream, GivesACapsuleWhenTheNextOneArrives) {
  const Packets packets = make(60);
  StreamDecoder decoder = decoderOf(packets);
  std::map<std::size_t, int> lost;
  const auto nodes = decode(decoder, streamOf(packets.packets), &lost);
  EXPECT_TRUE(lost.empty());
  EXPECT_EQ(keys(nodes), keys(packets, 0, 59));
  int starts = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_EQ(nodes[i].node.start, packets.nodes[i].start);
    starts += nodes[i].node.start;
  }
  EXPECT_EQ(starts, 59 * 24 / 360);
  EXPECT_EQ(decoder.counters().skipped_bytes + decoder.counters().bad_checksums + decoder.counters().encoder_resets +
                decoder.counters().wild_angles,
            0U);
}

TEST_P(CapsuleStream, AgesNodesByFilterTransmissionAndTheCapsuleBehind) {
  const Packets packets = make(4);
  StreamDecoder decoder = decoderOf(packets);
  const auto nodes = decode(decoder, streamOf(packets.packets));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const int k = static_cast<int>(i) % packets.samples;
    const double behind = packets.samples - 1 - k + packets.samples;
    EXPECT_NEAR(nodes[i].age, (1.5 + behind) * kSampleTime + static_cast<double>(packets.size) * kByteTime, 1e-9) << i;
  }
}

TEST_P(CapsuleStream, DropsTheHeldCapsuleAtABadChecksumAndCountsTheSamplesLost) {
  Packets packets = make(7);
  packets.packets[3][40] ^= 0x10;
  StreamDecoder decoder = decoderOf(packets);
  std::map<std::size_t, int> lost;
  const auto nodes = decode(decoder, streamOf(packets.packets), &lost);
  auto expected = keys(packets, 0, 2);  // 2 was held, 3 is damaged
  const auto tail = keys(packets, 4, 6);
  expected.insert(expected.end(), tail.begin(), tail.end());
  EXPECT_EQ(keys(nodes), expected);
  EXPECT_GE(decoder.counters().bad_checksums, 1U);
  const auto behind = static_cast<std::size_t>(2 * packets.samples);
  EXPECT_EQ(lost, (std::map<std::size_t, int>{{behind, 2 * packets.samples}}));
}

TEST_P(CapsuleStream, DropsTheHeldCapsuleAtALateStartBit) {
  const Packets packets = make(7, {0, 3});
  StreamDecoder decoder = decoderOf(packets);
  const auto nodes = decode(decoder, streamOf(packets.packets));
  auto expected = keys(packets, 0, 2);
  const auto tail = keys(packets, 3, 6);
  expected.insert(expected.end(), tail.begin(), tail.end());
  EXPECT_EQ(keys(nodes), expected);
  EXPECT_EQ(decoder.counters().encoder_resets, 1U);
}

TEST_P(CapsuleStream, DoesNotStretchACapsuleOverOnesThatAreMissing) {
  Packets packets = make(9);
  packets.packets.erase(packets.packets.begin() + 4);  // all of its bytes: no checksum tells
  StreamDecoder decoder = decoderOf(packets);
  auto expected = keys(packets, 0, 3);
  const auto tail = keys(packets, 5, 8);
  expected.insert(expected.end(), tail.begin(), tail.end());
  EXPECT_EQ(keys(decode(decoder, streamOf(packets.packets))), expected);
  EXPECT_EQ(decoder.counters().wild_angles, 1U);
}

TEST_P(CapsuleStream, DamagedAnywhereGivesNoWrongNodeAndRealigns) {
  const Packets packets = make(12);
  const Bytes stream = streamOf(packets.packets);
  const auto all = keys(packets, 0, 11);
  const std::set<Key> known(all.begin(), all.end());
  std::mt19937 random(7);
  for (std::size_t at = 0; at < 6 * packets.size; at += 1 + random() % 3) {
    for (int damage = 0; damage < 3; ++damage) {
      Bytes bytes = stream;
      const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      if (damage == 0) bytes.erase(place);
      if (damage == 1) bytes.insert(place, static_cast<std::uint8_t>(random()));
      if (damage == 2) *place ^= static_cast<std::uint8_t>(1 << random() % 8);
      StreamDecoder decoder = decoderOf(packets);
      const auto nodes = keys(decode(decoder, bytes));
      for (const Key& key : nodes) ASSERT_TRUE(known.contains(key)) << at << ' ' << damage;
      EXPECT_GE(nodes.size(), all.size() - static_cast<std::size_t>(3 * packets.samples)) << at << ' ' << damage;
      EXPECT_TRUE(std::equal(nodes.rbegin(), nodes.rbegin() + 3 * packets.samples, all.rbegin())) << at;
    }
  }
}

TEST_P(CapsuleStream, DoesNotAllocateOnceItIsBuilt) {
  Packets packets = make(30);
  packets.packets[7][9] ^= 1;
  const Bytes stream = streamOf(packets.packets);
  StreamDecoder decoder = decoderOf(packets);
  std::vector<TimedNode> nodes;
  nodes.reserve(StreamDecoder::kMostNodes);
  EXPECT_EQ(test::allocationsDuring([&] {
              for (const std::uint8_t byte : stream) {
                nodes.clear();
                decoder.push(byte, nodes);
              }
            }),
            0U);
}

INSTANTIATE_TEST_SUITE_P(Of, CapsuleStream, testing::Values(&ultra, &dense, &ultraDense), [](const auto& test) {
  return test.index == 0 ? "Ultra" : test.index == 1 ? "Dense" : "UltraDense";
});

TEST(StandardStreamLoss, IsCountedInSamples) {
  Bytes stream;
  for (int i = 0; i < 60; ++i) {
    const auto node =
        encodeStandardNode({.angle_q6 = static_cast<std::uint16_t>(64 * i), .distance_q2 = 4000, .quality = 15});
    stream.insert(stream.end(), node.begin(), node.end());
  }
  stream[5 * 20 + 1] ^= 1;  // check bit of node 20
  StreamDecoder decoder(AnswerType::kStandardNodes, 508e-6, kByteTime);
  std::map<std::size_t, int> lost;
  EXPECT_EQ(decode(decoder, stream, &lost).size(), 59U);
  EXPECT_EQ(lost, (std::map<std::size_t, int>{{20, 1}}));
}

TEST(PacketFormats, AreThoseOfTheTypesItReads) {
  EXPECT_EQ(packetFormat(0x81)->size, 5U);
  EXPECT_EQ(packetFormat(0x82)->size, 84U);
  EXPECT_EQ(packetFormat(0x84)->size, 132U);
  EXPECT_EQ(packetFormat(0x84)->samples, 96);
  EXPECT_EQ(packetFormat(0x85)->samples, 40);
  EXPECT_EQ(packetFormat(0x86)->samples, 64);
  for (const std::uint8_t other : Bytes{0x00, 0x04, 0x20, 0x80, 0x83, 0x87, 0xFF}) EXPECT_FALSE(packetFormat(other));
}

}  // namespace
}  // namespace slam::rplidar::rplidar_stream_test
