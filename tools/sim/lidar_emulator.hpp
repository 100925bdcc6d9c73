// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "core/timestamp.hpp"
#include "drivers/rplidar_codec.hpp"

namespace slam::sim {

/// An RPLidar A1M8 (firmware 1.29) at byte level: answers requests, streams standard nodes or express capsules paced as
/// the line allows. Pure: time and ranges come from outside.
class LidarEmulator {
 public:
  /// Range [m] measured at an instant and bearing [rad, counter-clockwise], 0 without return.
  using Measure = std::function<double(Timestamp, double bearing)>;

  LidarEmulator(Measure measure, double turn_rate) : measure_(std::move(measure)), turn_rate_(turn_rate) {}

  /// Bytes from the host. @param out answers are appended
  void receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out);
  /// Appends the measurement packets due up to `now`.
  void stream(Timestamp now, std::vector<std::uint8_t>& out);

  bool scanning() const { return mode_ != Mode::kIdle; }

 private:
  enum class Mode { kIdle, kStandard, kExpress };
  static constexpr std::uint16_t kStandardUs = 508, kExpressUs = 254;  // [us] per sample

  void handle(rplidar::Request request, Timestamp now, std::vector<std::uint8_t>& out);
  void startScan(Mode mode, Timestamp now);
  /// Raw angle of sample k, clockwise [deg].
  double rawAngle(std::int64_t sample) const;

  Measure measure_;
  double turn_rate_;
  std::vector<std::uint8_t> request_;  // bytes of an unfinished one
  Mode mode_ = Mode::kIdle;
  Timestamp started_{};
  std::int64_t sample_ = 0;  // next one to send
};

}  // namespace slam::sim
