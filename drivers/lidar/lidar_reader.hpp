// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/byte_stream.hpp"
#include "drivers/lidar/lidar_scan_stream.hpp"

namespace slam {

/// What a lidar's scan begins with.
struct LidarScanStart {
  std::unique_ptr<LidarScanStream> scans;
  std::vector<std::uint8_t> read_ahead;        ///< bytes of the scan that came with what began it
  bool busy_line = false;                      ///< it carries bytes nearly all the time
  Duration spin_up = std::chrono::seconds(3);  ///< until the first node, at most
  Duration pause{0};                           ///< between two packets
};

/// Reads a running scan until it ends: closed, restarted, standing, or silent.
class LidarReader {
 public:
  using Clock = Timestamp (*)();
  enum class Ending : std::uint8_t { kNone, kClosed, kRestarted, kHeadStands, kSilent };

  LidarReader(Clock now, LidarScanStart start);

  /// Waits up to `timeout` for bytes and hands finished scans to the sink.
  Ending read(ByteStream& stream, Duration timeout, const LidarScanStream::Sink& sink);
  const LidarScanStream& scans() const { return *scans_; }
  std::int64_t bytes() const { return bytes_; }            ///< that came
  std::int64_t nodes() const { return nodes_; }            ///< among them
  Timestamp lastArrival() const { return last_arrival_; }  ///< of a byte

 private:
  void take(std::span<const std::uint8_t> bytes, Timestamp arrival, const LidarScanStream::Sink& sink);

  Clock now_;
  std::unique_ptr<LidarScanStream> scans_;
  std::vector<std::uint8_t> read_ahead_;
  bool rests_;                // between reads
  Duration hold_up_;          // between two reads: what comes then has lost its time
  bool catching_up_ = false;  // with bytes that waited too long
  Timestamp last_node_, last_turn_, last_arrival_;
  std::uint32_t turns_ = 0;
  std::int64_t bytes_ = 0, nodes_ = 0;
};

}  // namespace slam
