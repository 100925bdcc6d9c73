// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/sim/lidar/emulated_lidar.hpp"
#include "tools/sim/lidar/lidar_faults.hpp"

namespace slam::sim {

/// What lidars share that measure at the same bearings each turn, send a turn at once, and take commands of text.
class TurnEmulator : public EmulatedLidar {
 public:
  struct Turn {
    int beams = 0;
    double first = 0.0, step = 0.0;  ///< [rad] bearing of the first beam, counter-clockwise, and between two
    Duration time{0};                ///< of a whole turn

    Duration untilLast() const;  ///< from the first beam to the last
  };

  void receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out) override;
  void stream(Timestamp now, std::vector<std::uint8_t>& out) override;
  /// Those of LidarFaults that are not an RPLidar's own.
  bool inject(std::string_view kind, double value) override;
  bool scanning() const override { return scanning_; }

 protected:
  /// @param end character that ends a command
  TurnEmulator(Measure measure, const Turn& turn, char end);

  /// A command has come. @return the answer
  virtual std::string answerTo(std::string_view command) = 0;
  /// A turn's message. @param ranges [m]; 0: no echo. @param began since the unit's start
  virtual std::string encode(std::span<const double> ranges, Duration began, std::uint32_t number) = 0;
  void setScanning(bool on) { scanning_ = on; }
  const LidarFaults& faults() const { return faults_; }

 private:
  void beginFaults(Timestamp now);

  Measure measure_;
  Turn turn_;
  char end_;
  LidarFaults faults_;
  std::string command_;  // unfinished
  bool scanning_ = false;
  Timestamp booted_{}, began_{}, paused_until_{};  // power on; the turn under way; no data until then
  std::uint32_t number_ = 0;                       // of the turn
};

}  // namespace slam::sim
