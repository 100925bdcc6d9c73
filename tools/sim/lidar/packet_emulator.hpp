// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/lidar/lidar_facts.hpp"
#include "tools/sim/lidar/emulated_lidar.hpp"
#include "tools/sim/lidar/lidar_faults.hpp"
#include "tools/sim/lidar/packet_encoders.hpp"

namespace slam::sim {

/// A lidar of the drivers' table at byte level: it turns and sends as soon as it has power, but one that
/// listens to commands waits for them.
class PacketEmulator : public EmulatedLidar {
 public:
  /// @param driver word of lidar.driver. @throws std::invalid_argument for one that nobody simulates
  PacketEmulator(Measure measure, std::string_view driver);

  void receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out) override;
  void stream(Timestamp now, std::vector<std::uint8_t>& out) override;
  /// Those of LidarFaults that are not an RPLidar's own.
  bool inject(std::string_view kind, double value) override;
  bool scanning() const override { return scanning_; }
  /// The unit has been running for so long.
  void setUptime(Duration uptime) { uptime_ = uptime; }

 private:
  void beginFaults(Timestamp now);
  std::vector<std::uint8_t> nextPacket();
  double look(Timestamp stamp, double angle);
  double turnRate() const { return faults_.turn > Duration(0) ? 1.0 / toSeconds(faults_.turn) : format_.turn_rate; }

  Measure measure_;
  const LidarFacts& facts_;
  const PacketFormat& format_;
  LidarFaults faults_;
  Duration sample_time_, byte_time_;
  Timestamp started_{}, next_{}, paused_until_{};  // power on; next sample; no data until then
  Duration uptime_{0};                             // at the start
  bool scanning_;
  std::vector<std::uint8_t> heard_;  // of an unfinished command
  double angle_ = 0.0;               // [deg] of the next sample, in the sense of the unit's angles
  std::deque<std::uint8_t> line_;    // bytes that are on their way
  Timestamp line_begin_{};           // when the first of them begins
};

}  // namespace slam::sim
