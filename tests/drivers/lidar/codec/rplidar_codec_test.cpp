// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/rplidar_codec.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "drivers/lidar/codec/rplidar_capsules.hpp"
#include "drivers/lidar/rplidar_stream.hpp"

namespace slam::rplidar::rplidar_codec_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::ElementsAre;

constexpr int kTurn = 360 * 64;                // [deg/64]
constexpr double kByteTime = 10.0 / 115200.0;  // [s]
constexpr double kStandardTime = 508e-6, kExpressTime = 254e-6;

template <std::size_t N>
Bytes bytesOf(const std::array<std::uint8_t, N>& array) {
  return {array.begin(), array.end()};
}

// ---- Requests, descriptors, single answers: DEVICES.md 1.2 to 1.4

TEST(RplidarRequest, WithoutPayloadIsTwoBytes) {
  EXPECT_THAT(encodeRequest(Request::kStop), ElementsAre(0xA5, 0x25));
  EXPECT_THAT(encodeRequest(Request::kReset), ElementsAre(0xA5, 0x40));
  EXPECT_THAT(encodeRequest(Request::kScan), ElementsAre(0xA5, 0x20));
  EXPECT_THAT(encodeRequest(Request::kGetInfo), ElementsAre(0xA5, 0x50));
  EXPECT_THAT(encodeRequest(Request::kGetHealth), ElementsAre(0xA5, 0x52));
  EXPECT_THAT(encodeRequest(Request::kGetSampleRate), ElementsAre(0xA5, 0x59));
}

TEST(RplidarRequest, WithPayloadHasSizeAndChecksum) {
  constexpr std::uint8_t kChecksum[] = {0x22, 0x23, 0x20, 0x21, 0x26};
  for (std::uint8_t mode = 0; mode < 5; ++mode) {
    EXPECT_THAT(encodeExpressScan(mode), ElementsAre(0xA5, 0x82, 0x05, mode, 0, 0, 0, 0, kChecksum[mode]));
  }
  EXPECT_THAT(encodeMotorPwm(660), ElementsAre(0xA5, 0xF0, 0x02, 0x94, 0x02, 0xC1));
  EXPECT_THAT(encodeMotorPwm(0), ElementsAre(0xA5, 0xF0, 0x02, 0x00, 0x00, 0x57));
  EXPECT_THAT(encodeRequest(Request::kGetAccessoryBoardFlag, Bytes(4)),
              ElementsAre(0xA5, 0xFF, 0x04, 0, 0, 0, 0, 0x5E));
}

struct DescriptorVector {
  Bytes bytes;
  std::uint32_t length;
  bool stream;
  std::uint8_t type;
};

class RplidarDescriptor : public testing::TestWithParam<DescriptorVector> {};

TEST_P(RplidarDescriptor, IsParsedAndEncodedByteForByte) {
  const auto& [bytes, length, stream, type] = GetParam();
  const auto descriptor = parseDescriptor(bytes);
  ASSERT_TRUE(descriptor);
  EXPECT_EQ(descriptor->length, length);
  EXPECT_EQ(descriptor->stream, stream);
  EXPECT_EQ(descriptor->type, type);
  EXPECT_EQ(bytesOf(encodeDescriptor(*descriptor)), bytes);
}

INSTANTIATE_TEST_SUITE_P(Of, RplidarDescriptor,
                         testing::Values(DescriptorVector{{0xA5, 0x5A, 0x14, 0, 0, 0, 0x04}, 20, false, 0x04},
                                         DescriptorVector{{0xA5, 0x5A, 0x03, 0, 0, 0, 0x06}, 3, false, 0x06},
                                         DescriptorVector{{0xA5, 0x5A, 0x04, 0, 0, 0, 0x15}, 4, false, 0x15},
                                         DescriptorVector{{0xA5, 0x5A, 0x05, 0, 0, 0x40, 0x81}, 5, true, 0x81},
                                         DescriptorVector{{0xA5, 0x5A, 0x54, 0, 0, 0x40, 0x82}, 84, true, 0x82},
                                         DescriptorVector{{0xA5, 0x5A, 0x0D, 0x03, 0, 0x40, 0x83}, 781, true, 0x83},
                                         DescriptorVector{{0xA5, 0x5A, 0x84, 0, 0, 0x40, 0x84}, 132, true, 0x84}));

TEST(RplidarDescriptorParser, RefusesWrongSizesAndStarts) {
  const Bytes good{0xA5, 0x5A, 0x14, 0, 0, 0, 0x04};
  EXPECT_FALSE(parseDescriptor({}));
  EXPECT_FALSE(parseDescriptor(std::span(good).first(6)));
  EXPECT_FALSE(parseDescriptor(Bytes{0xA5, 0x5A, 0x14, 0, 0, 0, 0x04, 0}));
  EXPECT_FALSE(parseDescriptor(Bytes{0xA5, 0xA5, 0x14, 0, 0, 0, 0x04}));
  EXPECT_FALSE(parseDescriptor(Bytes{0x5A, 0xA5, 0x14, 0, 0, 0, 0x04}));
}

TEST(RplidarAnswer, InfoOfARealA1) {
  Bytes data{24, 0x1D, 0x01, 7};
  for (std::uint8_t i = 0; i < 16; ++i) data.push_back(static_cast<std::uint8_t>(0xC0 + i));
  const auto info = parseInfo(data);
  ASSERT_TRUE(info);
  EXPECT_EQ(info->model, 24);
  EXPECT_EQ(info->firmware, 0x011D);
  EXPECT_EQ(info->hardware, 7);
  EXPECT_EQ(info->serial.front(), 0xC0);
  EXPECT_EQ(info->serial.back(), 0xCF);
  data.pop_back();
  EXPECT_FALSE(parseInfo(data));
}

TEST(RplidarAnswer, HealthHasThreeStates) {
  EXPECT_EQ(parseHealth(Bytes{0, 0, 0})->status, HealthStatus::kOk);
  EXPECT_EQ(parseHealth(Bytes{1, 0, 0})->status, HealthStatus::kWarning);
  const auto error = parseHealth(Bytes{2, 0x34, 0x12});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status, HealthStatus::kError);
  EXPECT_EQ(error->error_code, 0x1234);
  EXPECT_FALSE(parseHealth(Bytes{3, 0, 0}));
  EXPECT_FALSE(parseHealth(Bytes{0, 0}));
  EXPECT_FALSE(parseHealth(Bytes{0, 0, 0, 0}));
}

TEST(RplidarAnswer, SampleRateOfARealA1) {
  const auto rate = parseSampleRate(Bytes{0xFC, 0x01, 0xFE, 0x00});
  ASSERT_TRUE(rate);
  EXPECT_EQ(rate->standard_us, 508);
  EXPECT_EQ(rate->express_us, 254);
  EXPECT_FALSE(parseSampleRate(Bytes{0xFC, 0x01, 0xFE}));
}

// ---- Standard nodes: DEVICES.md 1.5

TEST(StandardNode, ExampleOfTheSpecification) {
  const Bytes bytes{0x3E, 0x9B, 0x64, 0x00, 0x00};
  const auto node = parseStandardNode(bytes);
  ASSERT_TRUE(node);
  EXPECT_EQ(node->quality, 15);
  EXPECT_FALSE(node->start);
  EXPECT_EQ(node->angle_q6, 12877);
  EXPECT_EQ(node->distance_q2, 0U);
  EXPECT_EQ(bytesOf(encodeStandardNode(*node)), bytes);
}

TEST(StandardNode, SurvivesARoundTrip) {
  const Node node{.angle_q6 = 23039, .distance_q2 = 0xFEDC, .quality = 63, .start = true};
  const auto back = parseStandardNode(encodeStandardNode(node));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->angle_q6, node.angle_q6);
  EXPECT_EQ(back->distance_q2, node.distance_q2);
  EXPECT_EQ(back->quality, node.quality);
  EXPECT_TRUE(back->start);
}

TEST(StandardNode, WithWrongCheckBitsIsRefused) {
  EXPECT_FALSE(parseStandardNode(Bytes{0x3C, 0x9B, 0x64, 0, 0}));  // S = not-S = 0
  EXPECT_FALSE(parseStandardNode(Bytes{0x3F, 0x9B, 0x64, 0, 0}));  // S = not-S = 1
  EXPECT_FALSE(parseStandardNode(Bytes{0x3E, 0x9A, 0x64, 0, 0}));  // C = 0
  EXPECT_FALSE(parseStandardNode(Bytes{0x3E, 0x9B, 0x64, 0}));
}

TEST(StandardNode, NeverHasAnAngleBeyondAWholeTurn) {
  for (int angle = 0; angle < 1 << 15; ++angle) {
    const auto low = static_cast<std::uint8_t>((angle & 0x7F) << 1 | 1), high = static_cast<std::uint8_t>(angle >> 7);
    const auto node = parseStandardNode(Bytes{0x3E, low, high, 0, 0});
    if (node) {
      EXPECT_LT(node->angle_q6, kTurn);
    } else {
      EXPECT_GE(angle, kTurn);
    }
  }
}

// ---- Express capsules: DEVICES.md 1.6

ExpressCapsule exampleCapsule() {
  ExpressCapsule capsule{.start_angle_q6 = 10 * 64, .start = true};
  for (std::size_t i = 0; i < 16; ++i) {
    capsule.samples[2 * i] = {static_cast<std::uint16_t>(1000 + i), 3};
    capsule.samples[2 * i + 1] = {static_cast<std::uint16_t>(2000 + i), 5};
  }
  return capsule;
}

TEST(ExpressCapsule, ExampleOfTheSpecification) {
  const Bytes bytes = bytesOf(encodeExpressCapsule(exampleCapsule()));
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 14),
              ElementsAre(0xA2, 0x50, 0x80, 0x82, 0xA0, 0x0F, 0x40, 0x1F, 0x53, 0xA4, 0x0F, 0x44, 0x1F, 0x53));
  const auto capsule = parseExpressCapsule(bytes);
  ASSERT_TRUE(capsule);
  EXPECT_EQ(capsule->start_angle_q6, 640);
  EXPECT_TRUE(capsule->start);
  EXPECT_EQ(capsule->samples[31].distance_mm, 2015);
  EXPECT_EQ(capsule->samples[31].offset_q3, 5);
  EXPECT_EQ(bytesOf(encodeExpressCapsule(*capsule)), bytes);
}

TEST(ExpressCapsule, TheOffsetIsUnsignedAndItsHighBitsSitBelowTheDistance) {
  ExpressCapsule capsule;
  capsule.samples[0] = {0x3FFF, 63};
  capsule.samples[1] = {1, 0x2A};
  const Bytes bytes = bytesOf(encodeExpressCapsule(capsule));
  EXPECT_THAT(Bytes(bytes.begin() + 4, bytes.begin() + 9), ElementsAre(0xFF, 0xFF, 0x06, 0x00, 0xAF));
  const auto back = parseExpressCapsule(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->samples[0].offset_q3, 63);
  EXPECT_EQ(back->samples[1].offset_q3, 0x2A);
  EXPECT_EQ(back->samples[0].distance_mm, 0x3FFF);
}

TEST(ExpressCapsule, WithAnyOneBitFlippedIsRefused) {
  Bytes bytes = bytesOf(encodeExpressCapsule(exampleCapsule()));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(parseExpressCapsule(bytes)) << "bit " << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
  }
  bytes.pop_back();
  EXPECT_FALSE(parseExpressCapsule(bytes));
}

TEST(ExpressCapsule, AnglesAreInterpolatedToTheNextCapsuleAndCorrected) {
  const auto nodes = decodeExpress(exampleCapsule(), 20 * 64);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    EXPECT_NEAR(nodes[k].angle_q6, 640 + 20 * static_cast<int>(k) - (k % 2 == 0 ? 24 : 40), 1) << k;
    EXPECT_EQ(nodes[k].distance_q2, 4 * ((k % 2 == 0 ? 1000 : 2000) + k / 2)) << k;
    EXPECT_GT(nodes[k].quality, 0);
    EXPECT_FALSE(nodes[k].start);
  }
}

TEST(ExpressCapsule, ATurnStartsAtTheSampleWhoseSuccessorIsPastZero) {
  ExpressCapsule capsule{.start_angle_q6 = 355 * 64 + 7};
  for (auto& sample : capsule.samples) sample = {1500, 10};  // 1.25 degrees off: the rule uses the raw angle
  const auto nodes = decodeExpress(capsule, 5 * 64 + 7);
  for (int k = 0; k < kExpressSamples; ++k) {
    const int raw = 355 * 64 + 7 + 20 * k;
    const Node& node = nodes[static_cast<std::size_t>(k)];
    EXPECT_EQ(node.start, (raw + 20) % kTurn < 20) << k;
    EXPECT_NEAR(node.angle_q6, (raw - 80) % kTurn, 1) << k;
  }
}

TEST(ExpressCapsule, AnOffsetMayTakeTheAngleBackThroughZero) {
  ExpressCapsule capsule{.start_angle_q6 = 0};
  capsule.samples[0] = {1500, 63};
  const auto nodes = decodeExpress(capsule, 10 * 64);
  EXPECT_EQ(nodes[0].angle_q6, kTurn - 63 * 8);
  EXPECT_EQ(nodes[1].distance_q2, 0U);  // no echo
}

TEST(ExpressCapsule, AnyStartAnglesGiveAnglesWithinATurn) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    ExpressCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(random() % 0x8000)};
    for (auto& sample : capsule.samples) sample = {1000, static_cast<std::uint8_t>(random() % 64)};
    for (const Node& node : decodeExpress(capsule, static_cast<std::uint16_t>(random() % 0x8000))) {
      ASSERT_LT(node.angle_q6, kTurn);
    }
  }
}

// ---- Streams

std::vector<TimedNode> decodeStream(StreamDecoder& decoder, const Bytes& bytes) {
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : bytes) decoder.push(byte, nodes);
  return nodes;
}

/// Identity of a node: angle and distance are unique in the streams below.
using Key = std::pair<int, std::uint32_t>;
Key keyOf(const Node& node) { return {node.angle_q6, node.distance_q2}; }

std::vector<Node> standardNodes(int count) {
  std::mt19937 random(4);
  std::vector<Node> nodes;
  for (int i = 0; i < count; ++i) {
    nodes.push_back({.angle_q6 = static_cast<std::uint16_t>((i % 90) * 256 + 64),
                     .distance_q2 = static_cast<std::uint32_t>(600 + random() % 40000),
                     .quality = 15,
                     .start = i % 90 == 0});
  }
  return nodes;
}

Bytes standardStream(const std::vector<Node>& nodes) {
  Bytes stream;
  for (const Node& node : nodes) {
    const auto bytes = encodeStandardNode(node);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  return stream;
}

std::vector<ExpressCapsule> expressCapsules(int count) {
  std::mt19937 random(5);
  std::vector<ExpressCapsule> capsules;
  for (int i = 0; i < count; ++i) {
    ExpressCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(i * 16 * 64 % kTurn), .start = i == 0};
    for (auto& sample : capsule.samples) {
      sample = {static_cast<std::uint16_t>(200 + random() % 10000), static_cast<std::uint8_t>(random() % 16)};
    }
    capsules.push_back(capsule);
  }
  return capsules;
}

Bytes expressStream(const std::vector<ExpressCapsule>& capsules) {
  Bytes stream;
  for (const ExpressCapsule& capsule : capsules) {
    const auto bytes = encodeExpressCapsule(capsule);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  return stream;
}

/// Nodes of all capsules but the last one, which waits for a successor.
std::vector<Node> expressNodes(const std::vector<ExpressCapsule>& capsules) {
  std::vector<Node> nodes;
  for (std::size_t i = 0; i + 1 < capsules.size(); ++i) {
    const auto part = decodeExpress(capsules[i], capsules[i + 1].start_angle_q6);
    nodes.insert(nodes.end(), part.begin(), part.end());
  }
  return nodes;
}

void expectSame(const std::vector<TimedNode>& actual, const std::vector<Node>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(keyOf(actual[i].node), keyOf(expected[i])) << i;
    EXPECT_EQ(actual[i].node.start, expected[i].start) << i;
  }
}

TEST(StandardStream, GivesEveryNodeOnceItIsAligned) {
  const auto expected = standardNodes(200);
  StreamDecoder decoder(AnswerType::kStandardNodes, kStandardTime, kByteTime);
  const auto nodes = decodeStream(decoder, standardStream(expected));
  expectSame(nodes, expected);
  EXPECT_EQ(decoder.counters().nodes, 200U);
  EXPECT_EQ(decoder.counters().skipped_bytes + decoder.counters().bad_check_bits, 0U);
}

TEST(ExpressStream, GivesACapsuleWhenTheNextOneArrives) {
  const auto capsules = expressCapsules(80);
  StreamDecoder decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
  const auto nodes = decodeStream(decoder, expressStream(capsules));
  expectSame(nodes, expressNodes(capsules));
  EXPECT_EQ(decoder.counters().nodes, 79U * 32U);
  EXPECT_EQ(decoder.counters().skipped_bytes + decoder.counters().bad_checksums + decoder.counters().encoder_resets,
            0U);
}

TEST(ExpressStream, HasOneStartATurn) {
  const auto capsules = expressCapsules(24 * 5);  // 16 degrees each: 5 1/3 turns
  const auto nodes = expressNodes(capsules);
  std::vector<std::ptrdiff_t> starts;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].start) starts.push_back(static_cast<std::ptrdiff_t>(i));
  }
  ASSERT_EQ(starts.size(), 5U);
  for (std::size_t i = 1; i < starts.size(); ++i) EXPECT_EQ(starts[i] - starts[i - 1], 720);  // 0.5 degrees a sample
}

TEST(StandardStream, AgesANodeByFilterAndTransmission) {
  StreamDecoder decoder(AnswerType::kStandardNodes, kStandardTime, kByteTime);
  std::vector<TimedNode> nodes;
  const auto stream = standardStream(standardNodes(20));
  for (const std::uint8_t byte : stream) {
    nodes.clear();
    decoder.push(byte, nodes);
  }
  ASSERT_EQ(nodes.size(), 1U);
  EXPECT_NEAR(nodes[0].age, 1.5 * kStandardTime + 5 * kByteTime, 1e-9);
}

TEST(ExpressStream, AgesNodesByTheirPlaceInTheCapsuleAndTheCapsuleAfterIt) {
  StreamDecoder decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
  const auto nodes = decodeStream(decoder, expressStream(expressCapsules(5)));
  ASSERT_EQ(nodes.size(), 4U * 32U);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto behind =
        static_cast<double>(31 - i % 32 + 32);  // samples of this capsule and of the one that completed it
    EXPECT_NEAR(nodes[i].age, (1.5 + behind) * kExpressTime + 84 * kByteTime, 1e-9) << i;
  }
}

TEST(ExpressStream, DropsTheHeldCapsuleAtABadChecksum) {
  const auto capsules = expressCapsules(6);
  Bytes stream = expressStream(capsules);
  stream[2 * kExpressCapsuleSize + 40] ^= 0x10;
  StreamDecoder decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
  const auto nodes = decodeStream(decoder, stream);
  const auto all = expressNodes(capsules);
  std::vector<Node> expected(all.begin(), all.begin() + 32);         // 0; 1 was held, 2 is damaged
  expected.insert(expected.end(), all.begin() + 3 * 32, all.end());  // 3 and 4
  expectSame(nodes, expected);
  EXPECT_GE(decoder.counters().bad_checksums, 1U);
}

TEST(ExpressStream, CountsALateStartBitAndDropsTheHeldCapsule) {
  auto capsules = expressCapsules(6);
  capsules[3].start = true;
  StreamDecoder decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
  const auto nodes = decodeStream(decoder, expressStream(capsules));
  EXPECT_EQ(decoder.counters().encoder_resets, 1U);
  std::set<Key> seen;
  for (const auto& node : nodes) seen.insert(keyOf(node.node));
  const auto all = expressNodes(capsules);
  for (const std::size_t kept : {0, 1, 4}) EXPECT_TRUE(seen.contains(keyOf(all[kept * 32]))) << kept;
  EXPECT_FALSE(seen.contains(keyOf(all[2 * 32])));
}

TEST(StreamDecoderReset, ForgetsHalfPacketsAndHeldCapsules) {
  const auto capsules = expressCapsules(4);
  const Bytes stream = expressStream(capsules);
  StreamDecoder decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
  std::vector<TimedNode> nodes;
  for (std::size_t i = 0; i < kExpressCapsuleSize + 30; ++i) decoder.push(stream[i], nodes);
  decoder.reset();
  nodes = decodeStream(decoder, stream);
  expectSame(nodes, expressNodes(capsules));
  EXPECT_EQ(decoder.counters().encoder_resets, 0U);  // a new scan begins with its S bit
}

enum class Damage : std::uint8_t { kLost, kInserted, kFlipped };

Bytes damaged(Bytes stream, Damage damage, std::size_t at, std::mt19937& random) {
  const auto place = stream.begin() + static_cast<std::ptrdiff_t>(at);
  switch (damage) {
    case Damage::kLost:
      stream.erase(place);
      break;
    case Damage::kInserted:
      stream.insert(place, static_cast<std::uint8_t>(random()));
      break;
    case Damage::kFlipped:
      *place ^= static_cast<std::uint8_t>(1 << random() % 8);
      break;
  }
  return stream;
}

class DamagedStream : public testing::TestWithParam<Damage> {};

/// What came out, compared with the undamaged nodes.
struct Outcome {
  std::size_t wrong = 0, lost = 0;
  bool tail_is_right = true;
};

Outcome compare(const std::vector<TimedNode>& actual, const std::vector<Node>& expected, std::size_t tail) {
  std::multiset<Key> missing;
  for (const Node& node : expected) missing.insert(keyOf(node));
  Outcome outcome;
  for (const auto& node : actual) {
    const auto found = missing.find(keyOf(node.node));
    if (found == missing.end()) {
      ++outcome.wrong;
    } else {
      missing.erase(found);
    }
  }
  outcome.lost = missing.size();
  outcome.tail_is_right =
      actual.size() >= tail && std::equal(expected.end() - static_cast<std::ptrdiff_t>(tail), expected.end(),
                                          actual.end() - static_cast<std::ptrdiff_t>(tail),
                                          [](const Node& a, const TimedNode& b) { return keyOf(a) == keyOf(b.node); });
  return outcome;
}

TEST_P(DamagedStream, OfStandardNodesRealignsWithinAFewNodes) {
  std::mt19937 random(6);
  const auto expected = standardNodes(240);
  const Bytes stream = standardStream(expected);
  std::size_t wrong = 0, cases = 0, unnoticed = 0;
  for (std::size_t at = 0; at < 180 * kStandardNodeSize; ++at, ++cases) {
    StreamDecoder decoder(AnswerType::kStandardNodes, kStandardTime, kByteTime);
    const auto nodes = decodeStream(decoder, damaged(stream, GetParam(), at, random));
    const Outcome outcome = compare(nodes, expected, 40);
    EXPECT_TRUE(outcome.tail_is_right) << at;
    EXPECT_LE(outcome.wrong, 10U) << at;
    EXPECT_LE(outcome.lost, 20U) << at;
    wrong += outcome.wrong;
    unnoticed += decoder.counters().bad_check_bits + decoder.counters().skipped_bytes == 0 ? 1U : 0U;
  }
  EXPECT_LE(wrong, 2 * cases);
  EXPECT_TRUE(unnoticed == 0 || GetParam() == Damage::kFlipped) << "only flips can be invisible to the check bits";
}

TEST_P(DamagedStream, OfCapsulesRealignsWithoutOneWrongNode) {
  std::mt19937 random(7);
  const auto capsules = expressCapsules(14);
  const auto expected = expressNodes(capsules);
  const Bytes stream = expressStream(capsules);
  for (std::size_t at = 0; at < 7 * kExpressCapsuleSize; ++at) {
    StreamDecoder decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
    const auto nodes = decodeStream(decoder, damaged(stream, GetParam(), at, random));
    const Outcome outcome = compare(nodes, expected, 4 * 32);
    EXPECT_TRUE(outcome.tail_is_right) << at;
    EXPECT_EQ(outcome.wrong, 0U) << at;
    EXPECT_LE(outcome.lost, 3 * 32U) << at;  // the damaged one, the one held, and at most one more
    EXPECT_GT(decoder.counters().bad_checksums + decoder.counters().skipped_bytes, 0U) << at;
  }
}

std::string nameOf(const testing::TestParamInfo<Damage>& info) {
  constexpr const char* kNames[] = {"Lost", "Inserted", "Flipped"};
  return kNames[static_cast<int>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Byte, DamagedStream, testing::Values(Damage::kLost, Damage::kInserted, Damage::kFlipped),
                         nameOf);

TEST(NoiseStream, NeverCrashesAndTheScanBehindItIsUsed) {
  std::mt19937 random(8);
  for (int round = 0; round < 50; ++round) {
    Bytes noise(1 + random() % 400);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? 0xA5 : random());
    Bytes standard = noise, express = noise;
    const auto nodes = standardNodes(240);
    const auto capsules = expressCapsules(14);
    for (const std::uint8_t byte : standardStream(nodes)) standard.push_back(byte);
    for (const std::uint8_t byte : expressStream(capsules)) express.push_back(byte);

    StreamDecoder standard_decoder(AnswerType::kStandardNodes, kStandardTime, kByteTime);
    EXPECT_TRUE(compare(decodeStream(standard_decoder, standard), nodes, 40).tail_is_right) << round;
    StreamDecoder express_decoder(AnswerType::kExpressCapsules, kExpressTime, kByteTime);
    EXPECT_TRUE(compare(decodeStream(express_decoder, express), expressNodes(capsules), 128).tail_is_right) << round;
  }
}

}  // namespace
}  // namespace slam::rplidar::rplidar_codec_test
