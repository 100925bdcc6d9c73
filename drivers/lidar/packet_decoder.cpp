// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/packet_decoder.hpp"

#include <utility>

namespace slam {

PacketDecoder::PacketDecoder(const LidarPackets& packets, double sample_time, double byte_time)
    : packets_(packets), sample_time_(sample_time), byte_time_(byte_time) {
  buffer_.reserve(packets.longest + 1);
  decoded_.reserve(packets.longest);
}

void PacketDecoder::reset() {
  buffer_.clear();
  skipped_ = size_ = 0;
  samples_ = lost_ = in_a_row_ = 0;
  angle_q6_.reset();
  turned_q6_ = 0;
}

void PacketDecoder::drop(std::size_t bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(bytes));
}

void PacketDecoder::push(std::uint8_t byte, std::vector<TimedNode>& nodes) {
  lost_ = 0;
  buffer_.push_back(byte);
  while (buffer_.size() >= packets_.head) {
    const std::size_t size = packets_.size({buffer_.data(), packets_.head});
    if (size > buffer_.size()) return;
    if (size > 0 && packets_.good({buffer_.data(), size})) {
      take(size, nodes);
      continue;
    }
    rejects_ += in_a_row_ > 0;  // where a packet was due
    in_a_row_ = 0;
    drop(1);
    ++skipped_;
  }
}

void PacketDecoder::take(std::size_t size, std::vector<TimedNode>& nodes) {
  // The unit samples on while a receiver skips bytes: each packet's worth of them is its samples lost.
  if (size_ > 0) lost_ += static_cast<int>((skipped_ + size_ / 2) / size_) * samples_;
  decoded_.clear();
  packets_.nodes({buffer_.data(), size}, decoded_);
  const double behind = byte_time_ * static_cast<double>(buffer_.size());  // [s] from its first byte to the newest
  for (std::size_t k = 0; k < decoded_.size(); ++k) {
    LidarNode node = decoded_[k];
    node.start = startsTurn(node.angle_q6);
    nodes.push_back({node, sample_time_ * static_cast<double>(decoded_.size() - 1 - k) + behind});
  }
  samples_ = static_cast<int>(decoded_.size());
  size_ = size;
  skipped_ = 0;
  ++in_a_row_;
  drop(size);
}

/// A beam's angle may lie some degrees before its predecessor's where a unit triangulates: half a turn lies between two
/// starts at least.
bool PacketDecoder::startsTurn(std::uint16_t angle_q6) {
  constexpr int kTurnQ6 = 360 * 64;
  const int jump = angle_q6 - std::exchange(angle_q6_, angle_q6).value_or(angle_q6);
  turned_q6_ += jump < -kTurnQ6 / 2 ? jump + kTurnQ6 : jump > kTurnQ6 / 2 ? jump - kTurnQ6 : jump;
  if (jump >= -kTurnQ6 / 2 || turned_q6_ < kTurnQ6 / 2) return false;
  turned_q6_ = 0;
  return true;
}

}  // namespace slam
