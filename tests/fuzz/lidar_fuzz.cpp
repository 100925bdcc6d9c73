// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses a lidar of the table, then what it sends.
#include <algorithm>
#include <vector>

#include "drivers/lidar/lidar_facts.hpp"
#include "drivers/lidar/packet_decoder.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/sim/lidar/packet_encoders.hpp"

namespace slam {
namespace {

using fuzz::Bytes;

constexpr int kTurnQ6 = 360 * 64;
constexpr std::size_t kGoodPackets = 60;  // more than what one false head may hide

std::size_t pushAll(PacketDecoder& decoder, Bytes bytes) {
  std::size_t count = 0;
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : bytes) {
    const std::int64_t rejects = decoder.rejects();
    nodes.clear();
    decoder.push(byte, nodes);
    FUZZ_CHECK(nodes.size() <= decoder.mostNodes() && decoder.lost() >= 0 && decoder.rejects() >= rejects);
    for (const TimedNode& timed : nodes) {
      FUZZ_CHECK(timed.node.angle_q6 < kTurnQ6 && timed.node.distance_q2 < 4U << 16);
      FUZZ_CHECK(timed.age > 0.0 && timed.age < 1.0);
    }
    count += nodes.size();
  }
  return count;
}

void check(const LidarFacts& facts, Bytes input) {
  PacketDecoder decoder(*facts.packets, 1.0 / facts.sample_rate, 10.0 / facts.baud);
  FUZZ_CHECK(pushAll(decoder, input) <= input.size());
  // Whatever came before: good packets behind it are read, but for those that a false head has hidden.
  const sim::PacketFormat* format = sim::findPacketFormat(facts.driver);
  sim::PacketContents contents;
  for (int i = 0; i < format->samples; ++i) {
    contents.angles.push_back(static_cast<double>(i));
    contents.ranges.push_back(1.234);
  }
  const std::vector<std::uint8_t> packet = format->encode(contents);
  std::size_t read = 0;
  for (std::size_t i = 0; i < kGoodPackets; ++i) read += pushAll(decoder, packet);
  const std::size_t hidden = facts.packets->longest / packet.size() + 2;
  FUZZ_CHECK(read >= (kGoodPackets - hidden) * static_cast<std::size_t>(format->samples));
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return -1;
  const auto table = slam::lidarTable();
  slam::check(table[data[0] % table.size()], {data + 1, size - 1});
  return 0;
}
