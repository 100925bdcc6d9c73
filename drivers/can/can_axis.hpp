// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <optional>

#include "core/timestamp.hpp"
#include "firmware_if/can_odrive.hpp"

namespace slam {

/// What is known of one wheel's drive besides the angle of its wheel.
class CanAxis {
 public:
  void addHeartbeat(Timestamp stamp, const can::odrive::Heartbeat& heartbeat) {
    // A damaged frame is not an error of the drive: what it says has to come twice.
    if (last_ && last_->axis_error == heartbeat.axis_error && last_->state == heartbeat.state) said_ = heartbeat;
    last_ = heartbeat;
    heartbeat_ = stamp;
  }
  void addEstimates(Timestamp stamp, const can::odrive::EncoderEstimates& estimates) {
    const bool moved = estimates.position != position_ || std::abs(estimates.velocity) < kTurning;
    if (moved || stamp - estimates_ > kFrozen) moved_ = stamp;
    position_ = estimates.position;
    estimates_ = stamp;
  }

  Timestamp heartbeat() const { return heartbeat_; }  ///< when the last one came
  Timestamp estimates() const { return estimates_; }  ///< the same
  const std::optional<can::odrive::Heartbeat>& said() const { return said_; }
  bool faulty() const {
    return said_ && (said_->axis_error != 0 || said_->motor_error || said_->encoder_error || said_->controller_error);
  }
  bool inClosedLoop() const { return said_ && said_->state == std::uint8_t(can::odrive::AxisState::kClosedLoop); }
  /// Its position stays the same although it says that the wheel turns.
  bool frozen() const { return estimates_ - moved_ > kFrozen; }
  /// Its position is no measurement.
  bool lies() const { return frozen() || (said_ && said_->encoder_error); }

 private:
  static constexpr float kTurning = 0.05F;  // [turns/s]
  static constexpr Duration kFrozen = std::chrono::milliseconds(300);
  std::optional<can::odrive::Heartbeat> last_, said_;
  Timestamp heartbeat_{}, estimates_{}, moved_{};
  float position_ = 0.0F;  // [turns]
};

}  // namespace slam
