// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "base_frame.hpp"

namespace slamd_base {

/// Speed control of one wheel: what the motor needs for that speed by `most`, corrected by what the encoder counts.
struct ControlGains {
  float most;          ///< [counts/s] of a wheel at full duty, measured on the robot
  float proportional;  ///< [1] duty for an error of `most`
  float integral;      ///< [1/s] the same, in each second
};

/// What the reference firmware decides: how the motors are driven, and when they are stopped. Without pins and clock,
/// so that tests and slam-sim run the same lines as the microcontroller.
class BaseControl {
 public:
  explicit BaseControl(const ControlGains& gains) : gains_(gains) {}

  /// SPEEDS have come. @param now [us]
  void command(const Speeds& speeds, uint32_t now);
  /// To be called at a fixed rate. @param now [us] @param counts of the encoders
  void step(uint32_t now, const int32_t counts[2]);

  /// [counts/s] that the wheel shall have: 0 without SPEEDS for kCommandLasts.
  int32_t wanted(uint8_t side) const { return driven_ ? speeds_.speeds[side] : 0; }
  float duty(uint8_t side) const { return duty_[side]; }  ///< [1] of the motor, -1..1, forward positive
  bool driven() const { return driven_; }
  uint8_t number() const { return speeds_.number; }  ///< of the SPEEDS received last

 private:
  float dutyFor(uint8_t side, float measured, float elapsed);

  ControlGains gains_;
  Speeds speeds_ = {0, {0, 0}};
  uint32_t commanded_ = 0, stepped_ = 0;  // [us]
  bool driven_ = false, started_ = false;
  int32_t counts_[2] = {0, 0};
  float integral_[2] = {0.0F, 0.0F};  // [1] of the duty
  float duty_[2] = {0.0F, 0.0F};
};

}  // namespace slamd_base
