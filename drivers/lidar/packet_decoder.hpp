// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/lidar/codec/lidar_packets.hpp"
#include "drivers/lidar/lidar_decoder.hpp"

namespace slam {

/// Finds packets among bytes and gives their nodes. Behind damage it looks for the next packet from byte to byte,
/// because a head may stand within a packet. A turn begins where the angle passes zero, so that it does whichever
/// packet was lost.
class PacketDecoder : public LidarDecoder {
 public:
  /// @param sample_time [s] per sample @param byte_time [s] on the line
  PacketDecoder(const LidarPackets& packets, double sample_time, double byte_time);

  void push(std::uint8_t byte, std::vector<TimedNode>& nodes) override;
  void reset() override;
  std::size_t mostNodes() const override { return packets_.longest; }
  /// Packets that came one behind the other up to now.
  int inARow() const { return in_a_row_; }

 private:
  void drop(std::size_t bytes);
  void take(std::size_t size, std::vector<TimedNode>& nodes);
  bool startsTurn(std::uint16_t angle_q6);

  const LidarPackets& packets_;
  double sample_time_, byte_time_;
  std::vector<std::uint8_t> buffer_;
  std::vector<LidarNode> decoded_;
  std::size_t skipped_ = 0;  // [bytes] since the last packet
  std::size_t size_ = 0;     // [bytes] of that
  int samples_ = 0;          // of that
  int in_a_row_ = 0;
  std::optional<std::uint16_t> angle_q6_;  // of the last node
  int turned_q6_ = 0;                      // [deg * 64] since the turn's start
};

}  // namespace slam
