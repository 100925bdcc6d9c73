// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/timestamp.hpp"
#include "firmware_if/can_odrive.hpp"
#include "firmware_if/can_vesc.hpp"

namespace slam {

/// Makes estimates of the motor's turns, as an ODrive sends them, of a VESC's status frames: the position by the
/// tachometer of STATUS_5, the speed by the electric turns of STATUS. Both have to come.
class VescDrive {
 public:
  /// Of one frame.
  struct News {
    bool is_status = false;  ///< the VESC is alive
    std::optional<can::odrive::EncoderEstimates> estimates{};
  };

  VescDrive(int id, int pole_pairs) : id_(id), pole_pairs_(pole_pairs > 0 ? pole_pairs : 1) {}

  News take(Timestamp stamp, const can::Frame& frame) {
    if (const auto status = can::vesc::parseStatus(id_, frame)) {
      erpm_ = status->erpm;
      erpm_at_ = stamp;
      return {.is_status = true};
    }
    if (const auto status = can::vesc::parseStatus4(id_, frame)) {
      transistors_ = kDegrees * status->transistors;
      return {.is_status = true};
    }
    const auto status = can::vesc::parseStatus5(id_, frame);
    if (!status) return {};
    if (!erpm_at_ || stamp - *erpm_at_ > kFresh) return {.is_status = true};
    const double turns = status->tachometer * step(), speed = erpm_ / (kSeconds * pole_pairs_);
    return {.is_status = true, .estimates = {{static_cast<float>(turns), static_cast<float>(speed)}}};
  }
  /// @param speed [turns/s] of the motor @return as the VESC is asked for it
  can::Frame encodeSpeed(double speed) const {
    constexpr double kMost = 1e9;  // [1/min]
    const double erpm = std::fmin(std::fmax(speed * kSeconds * pole_pairs_, -kMost), kMost);
    return can::vesc::encodeSetRpm(id_, static_cast<std::int32_t>(std::lround(erpm)));
  }
  double step() const { return 1.0 / (can::vesc::kStepsPerElectricTurn * pole_pairs_); }  ///< [turns] of its position
  double transistors() const { return transistors_; }                                     ///< [deg C]; 0: not known

 private:
  static constexpr Duration kFresh = std::chrono::milliseconds(500);  // the slower of the rates is 5 Hz as delivered
  static constexpr double kSeconds = 60.0, kDegrees = 0.1;            // in a minute; [deg C] of a digit

  int id_, pole_pairs_;
  std::int32_t erpm_ = 0;  // [1/min]
  std::optional<Timestamp> erpm_at_;
  double transistors_ = 0.0;
};

}  // namespace slam
