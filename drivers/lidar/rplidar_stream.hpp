// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/lidar/codec/rplidar_capsules.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "drivers/lidar/lidar_decoder.hpp"

namespace slam::rplidar {

/// What a scan's stream consists of.
struct PacketFormat {
  std::size_t size = 0;  ///< [bytes]
  int samples = 0;
  std::size_t angle_at = kCapsuleAngleAt;  ///< [bytes] of a capsule
};
/// @param type of a descriptor. @return std::nullopt for one that StreamDecoder cannot read
std::optional<PacketFormat> packetFormat(std::uint8_t type);

struct DecoderCounters {
  std::uint64_t nodes = 0;
  std::uint32_t bad_check_bits = 0;  ///< standard nodes whose S or C bits are wrong
  std::uint32_t bad_checksums = 0;   ///< capsules, or none where one was due
  std::uint32_t encoder_resets = 0;  ///< capsules with a late S bit
  std::uint32_t wild_angles = 0;     ///< capsules whose successor is not where it should be
  std::uint32_t skipped_bytes = 0;   ///< bytes that belonged to no node or capsule
};

/// Nodes out of a scan's stream of bytes, whatever damage it has. After damage it realigns: for standard nodes it asks
/// for kAlignNodes good ones in a row, because random bytes pass the check bits with probability 1/4. Does not allocate
/// after construction if `nodes` has room.
class StreamDecoder final : public LidarDecoder {
 public:
  static constexpr int kAlignNodes = 5;
  static constexpr std::size_t kMostNodes = kUltraSamples;  ///< that one byte can complete
  static constexpr std::size_t kLongestPacket = kUltraDenseCapsuleSize;

  /// @param type         kStandardNodes or one of the capsules
  /// @param sample_time  [s] per sample
  /// @param byte_time    [s] on the line
  StreamDecoder(AnswerType type, double sample_time, double byte_time);

  void push(std::uint8_t byte, std::vector<TimedNode>& nodes) override;
  void reset() override;
  std::size_t mostNodes() const override { return kMostNodes; }
  std::int64_t rejects() const override {
    return static_cast<std::int64_t>(counters_.bad_check_bits) + counters_.bad_checksums + counters_.wild_angles;
  }
  std::uint32_t zeroShifts() const override { return counters_.encoder_resets; }
  const DecoderCounters& counters() const { return counters_; }

 private:
  void pushStandard(std::vector<TimedNode>& nodes);
  void pushCapsule(std::vector<TimedNode>& nodes);
  void decodeHeld(const CapsuleHead& next_head, std::vector<TimedNode>& nodes);
  template <typename Nodes>
  void emit(const Nodes& decoded, std::vector<TimedNode>& nodes);
  void countLost(std::uint64_t packet_begin);
  void drop(std::size_t bytes);

  AnswerType type_;
  PacketFormat format_;
  double sample_time_, byte_time_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t buffer_begin_ = 0;              // [bytes] of the stream before the buffer
  std::optional<std::uint64_t> next_expected_;  // [bytes] where the packet after the one decoded last begins
  bool aligned_ = false;                        // standard nodes
  std::optional<CapsuleHead> held_head_;        // a capsule waits for the start angle of the next one
  std::array<std::uint8_t, kLongestPacket> held_{};
  std::uint64_t held_begin_ = 0;  // [bytes]
  bool first_capsule_ = true;
  int width_q6_ = 0;  // [deg * 64] from the last capsule to its successor; 0: not known
  DecoderCounters counters_;
};

}  // namespace slam::rplidar
