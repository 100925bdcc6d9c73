// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <string>

#include "drivers/can/can_link.hpp"
#include "firmware_if/can_odrive.hpp"

namespace slam {

/// The words for what can be wrong on a CAN bus. Made at start-up, so that a real-time thread only points at them; the
/// texts stay what and where they are until this goes.
class CanTexts {
 public:
  /// @param nodes of the left and the right wheel @param commands slamd drives them, and says what it does about it
  CanTexts(const std::string& interface, const std::array<int, 2>& nodes, bool commands = false);

  const char* link(CanLinkState state) const;
  /// What a drive says of itself. Room for 32 different texts is made at start-up; after that they say less.
  const char* axis(std::size_t side, const can::odrive::Heartbeat& heartbeat);
  /// A drive sends its estimates more seldom than it should. Periods are told to ten milliseconds.
  const char* slow(std::size_t side, Duration period);

  std::string gone, down, bus_off, passive, unsupported, refused, blocked;
  std::array<std::string, 2> no_frames, no_estimates, bad_estimates, no_heartbeat, frozen, not_closed_loop,
      not_following,
      shared_id;  // left, right
  std::string no_wheels, opening_wheels, opening_imu, no_imu, no_rate, no_acceleration, no_time, senseless_imu;
  std::string frozen_imu, senseless, rare_time, rare_acceleration;

 private:
  struct AxisText {
    std::size_t side = 0;
    can::odrive::Heartbeat heartbeat;
    std::array<char, 320> text{};
  };
  std::array<AxisText, 32> axis_texts_;
  std::size_t axis_count_ = 0;
  struct SlowText {
    std::size_t side = 0;
    Duration period{0};
    std::array<char, 160> text{};
  };
  std::array<SlowText, 16> slow_texts_;
  std::size_t slow_count_ = 0;
  std::array<std::string, 2> slow_;
  std::array<std::string, 2> axis_error_, remedy_;  // what slamd does about it, and the fix
};

}  // namespace slam
