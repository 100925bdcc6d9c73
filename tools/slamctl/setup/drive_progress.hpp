// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/pose2.hpp"

namespace slam {

/// How far a drive is that is recorded for a calibration.
struct DriveProgress {
  static constexpr double kEnoughWay = 3.0;   ///< [m] straight on
  static constexpr double kEnoughTurn = 5.5;  ///< [rad] to each side: nearly a whole turn

  enum Phase : std::uint8_t { kBegins, kDrives, kOver } phase = kDrives;
  double seconds = 0.0, length = 0.0;  ///< [s] driven, and to be driven
  double way = 0.0, straight = 0.0;    ///< [m] driven, and how much of it without turning
  double left = 0.0, right = 0.0;      ///< [rad] turned to each side
};

/// Follows a log that grows. Each look reads what is new in it.
class DriveWatch {
 public:
  explicit DriveWatch(std::filesystem::path log) : log_(std::move(log)) {}

  void look();
  /// Scans and wheels have come.
  bool hasSensors() const { return scans_ && T_wheels_begin_; }
  /// Way and turns so far.
  const DriveProgress& driven() const { return driven_; }

 private:
  void move(const Pose2& T_wheels_base);

  const std::filesystem::path log_;
  std::uint64_t read_ = 0;  // [bytes]
  bool scans_ = false;
  std::optional<Pose2> T_wheels_begin_;  // where the stretch began that is driven now
  DriveProgress driven_;
};

}  // namespace slam
