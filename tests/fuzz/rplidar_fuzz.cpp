// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses what is listened to, then what an RPLidar sends.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "drivers/lidar/codec/rplidar_modes.hpp"
#include "drivers/lidar/rplidar_scan_stream.hpp"
#include "drivers/lidar/rplidar_stream.hpp"
#include "fuzz/fuzzing.hpp"

namespace slam::rplidar {
namespace {

using fuzz::Bytes;

constexpr std::array kStreams = {AnswerType::kStandardNodes, AnswerType::kExpressCapsules, AnswerType::kUltraCapsules,
                                 AnswerType::kDenseCapsules, AnswerType::kUltraDenseCapsules};
constexpr double kSampleTime = 254e-6, kByteTime = 10.0 / 115200.0;  // [s]
constexpr int kTurnQ6 = 360 * 64;
constexpr int kGoodPackets = 12;

/// A packet that the unit might send, in which no second one begins: neither check bits nor sync nibbles fit elsewhere.
std::vector<std::uint8_t> goodPacket(AnswerType type, int index) {
  const auto angle_q6 = static_cast<std::uint16_t>(index * 512 + 1);
  const auto vector = [](const auto& bytes) { return std::vector<std::uint8_t>(bytes.begin(), bytes.end()); };
  switch (type) {
    case AnswerType::kExpressCapsules: {
      ExpressCapsule capsule{.start_angle_q6 = angle_q6};
      for (auto& sample : capsule.samples) sample = {1024, 1};
      return vector(encodeExpressCapsule(capsule));
    }
    case AnswerType::kUltraCapsules: {
      UltraCapsule capsule{.start_angle_q6 = angle_q6};
      for (auto& cabin : capsule.cabins) cabin = {1, 2, 3};
      return vector(encodeUltraCapsule(capsule));
    }
    case AnswerType::kDenseCapsules: {
      DenseCapsule capsule{.start_angle_q6 = angle_q6};
      capsule.distances_mm.fill(1025);
      return vector(encodeDenseCapsule(capsule));
    }
    case AnswerType::kUltraDenseCapsules: {
      UltraDenseCapsule capsule{.start_angle_q6 = angle_q6};
      capsule.samples.fill({1032, 1});
      return vector(encodeUltraDenseCapsule(capsule));
    }
    default:
      return vector(encodeStandardNode({.angle_q6 = angle_q6, .distance_q2 = 4096, .quality = 15}));
  }
}

std::vector<TimedNode> pushAll(StreamDecoder& decoder, Bytes bytes) {
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : bytes) {
    const DecoderCounters before = decoder.counters();
    const std::size_t count = nodes.size();
    decoder.push(byte, nodes);
    const DecoderCounters& after = decoder.counters();
    FUZZ_CHECK(nodes.size() - count <= StreamDecoder::kMostNodes && decoder.lost() >= 0);
    FUZZ_CHECK(after.nodes == before.nodes + (nodes.size() - count));
    FUZZ_CHECK(after.bad_check_bits >= before.bad_check_bits && after.bad_checksums >= before.bad_checksums &&
               after.encoder_resets >= before.encoder_resets && after.wild_angles >= before.wild_angles &&
               after.skipped_bytes >= before.skipped_bytes);
  }
  for (const TimedNode& timed : nodes) {
    FUZZ_CHECK(timed.node.angle_q6 < kTurnQ6);
    FUZZ_CHECK(timed.age > 0.0 && timed.age < 1.0);
  }
  return nodes;
}

bool sameNode(const TimedNode& a, const TimedNode& b) {
  return a.node.angle_q6 == b.node.angle_q6 && a.node.distance_q2 == b.node.distance_q2 &&
         a.node.quality == b.node.quality && a.node.start == b.node.start && a.age == b.age;
}

void checkDecoder(AnswerType type, Bytes input) {
  const PacketFormat format = *packetFormat(static_cast<std::uint8_t>(type));
  StreamDecoder decoder(type, kSampleTime, kByteTime), fresh(type, kSampleTime, kByteTime);
  const std::size_t count = pushAll(decoder, input).size();
  FUZZ_CHECK(count * format.size <= input.size() * static_cast<std::size_t>(format.samples));
  FUZZ_CHECK(decoder.counters().skipped_bytes <= input.size());

  // Whatever came before: of good packets, those behind the first ones come out as they were sent.
  std::vector<std::uint8_t> good;
  for (int i = 0; i < kGoodPackets; ++i) {
    const auto packet = goodPacket(type, i);
    good.insert(good.end(), packet.begin(), packet.end());
  }
  const std::vector<TimedNode> received = pushAll(decoder, good), expected = pushAll(fresh, good);
  // Packets that damage before them may cost, or age while nodes are being aligned.
  const int damaged = type == AnswerType::kStandardNodes ? StreamDecoder::kAlignNodes + 2 : 3;
  const std::size_t due = expected.size() - static_cast<std::size_t>(damaged * format.samples);
  FUZZ_CHECK(due < expected.size() && received.size() >= due);
  FUZZ_CHECK(std::equal(received.end() - static_cast<std::ptrdiff_t>(due), received.end(),
                        expected.end() - static_cast<std::ptrdiff_t>(due), sameNode));
}

/// Scans out of chunks, as the driver's thread makes them.
void checkScans(AnswerType type, Bytes input) {
  static ScanStream* const streams[] = {new ScanStream({.type = kStreams[0]}), new ScanStream({.type = kStreams[1]}),
                                        new ScanStream({.type = kStreams[2]}), new ScanStream({.type = kStreams[3]}),
                                        new ScanStream({.type = kStreams[4]})};
  const auto index = static_cast<std::size_t>(std::find(kStreams.begin(), kStreams.end(), type) - kStreams.begin());
  ScanStream& stream = *streams[index];  // some 130 kB: made once
  stream.restart();
  Timestamp arrival(std::chrono::seconds(1000)), last_stamp{};
  const auto sink = [&](const LaserScan& scan) {
    FUZZ_CHECK(scan.size > 0 && scan.size <= LaserScan::kCapacity);
    FUZZ_CHECK(scan.stamp >= last_stamp && scan.stamp <= arrival);
    last_stamp = scan.stamp;
    for (const Beam& beam : scan.beams()) {
      FUZZ_CHECK(std::abs(beam.bearing) < 3.15F && beam.range >= 0.0F && beam.range < 300.0F);
      FUZZ_CHECK(beam.time_offset >= 0.0F);
    }
  };
  fuzz::Input bytes(input);
  while (!bytes.atEnd()) {
    const std::uint8_t size = bytes.take<std::uint8_t>();
    const Bytes chunk = bytes.takeBytes(size);
    arrival += fromSeconds(kByteTime * static_cast<double>(chunk.size()) + 1e-3 * (size % 16));
    const int nodes = chunk.empty() ? 0 : stream.push(chunk, arrival, sink);
    FUZZ_CHECK(nodes >= 0 && stream.rejects() >= 0);
  }
}

/// Everything that is said outside of a scan.
void checkAnswers(Bytes input) {
  if (const auto descriptor = parseDescriptor(input); descriptor && (input[5] & 0x80) == 0) {
    FUZZ_CHECK(std::ranges::equal(encodeDescriptor(*descriptor), input));
  }
  if (const auto node = parseStandardNode(input)) {
    const auto again = parseStandardNode(encodeStandardNode(*node));
    FUZZ_CHECK(again && again->angle_q6 == node->angle_q6 && again->distance_q2 == node->distance_q2);
  }
  const auto info = parseInfo(input);
  FUZZ_CHECK(info.has_value() == (input.size() == 20));
  const auto health = parseHealth(input);
  FUZZ_CHECK(!health || health->status <= HealthStatus::kError);
  const auto rate = parseSampleRate(input);
  FUZZ_CHECK(!rate || (rate->standard_us > 0 && rate->express_us > 0));

  std::vector<ScanMode> listed;
  fuzz::Input bytes(input);
  while (!bytes.atEnd() && listed.size() < kMostModes) {
    ScanMode mode{.id = static_cast<std::uint16_t>(listed.size())};
    if (const auto time = parseSampleTime(bytes.takeBytes(4))) mode.sample_time = *time;
    if (const auto type = parseAnswerType(bytes.takeBytes(1))) mode.answer_type = *type;
    mode.name = parseModeName(bytes.takeBytes(8));
    FUZZ_CHECK(mode.name.back() == '\0' && mode.sample_time > 0.0 && mode.sample_time < 0.01);
    listed.push_back(mode);
  }
  for (const ModeWish wish : {ModeWish::kDensest, ModeWish::kExpress, ModeWish::kStandard}) {
    const auto modes =
        modesToTry(wish, kFirmwareWithModes, rate.value_or(SampleRate{508, 254}), listed, std::uint16_t{1});
    FUZZ_CHECK(!modes.empty() && modes.size() <= listed.size() + 2);
    for (const ScanMode& mode : modes) FUZZ_CHECK(packetFormat(mode.answer_type).has_value());
  }
  for (const auto entry : {ConfigurationEntry::kModeCount, ConfigurationEntry::kModeName}) {
    if (const auto payload = parseConfiguration(entry, input)) {
      FUZZ_CHECK(payload->size() + 4 == input.size());
      parseModeNumber(*payload);
      parseMaxDistance(*payload);
      parseModeName(*payload);
    }
  }
}

}  // namespace
}  // namespace slam::rplidar

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam::rplidar;
  if (size == 0) return -1;
  const Bytes input{data + 1, size - 1};
  const std::size_t choice = data[0] % (2 * kStreams.size() + 1);
  if (choice < kStreams.size()) {
    checkDecoder(kStreams[choice], input);
  } else if (choice < 2 * kStreams.size()) {
    checkScans(kStreams[choice - kStreams.size()], input);
  } else {
    checkAnswers(input);
  }
  return 0;
}
