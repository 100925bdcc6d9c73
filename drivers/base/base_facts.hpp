// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "drivers/base/base_protocol.hpp"
#include "drivers/line_device.hpp"

namespace slam {

/// What a protocol needs to know of the robot.
struct BaseProtocolConfig {
  double wheel_radius = 0.0;                      ///< [m]
  double half_track = 0.0;                        ///< [m]
  double counts_per_turn = 0.0;                   ///< of a wheel
  double loop_rate = 0.0;                         ///< [Hz] of the speed control of a base that takes counts per loop
  std::uint8_t address = 0x80;                    ///< of a RoboClaw
  std::array<std::uint8_t, 2> nodes{0x10, 0x18};  ///< ids on CAN of two VESCs: left, right
  bool may_drive = false;
};

/// A base at a serial port, as a row of the table.
struct BaseFacts {
  const char* driver;      ///< word of base.driver
  const char* name;        ///< in words
  LineDevice line_device;  ///< as others on the port know it
  std::unique_ptr<BaseProtocol> (*make)(const BaseProtocolConfig&);
  int baud;                      ///< [bit/s]
  int counter_bits;              ///< 16 or 32
  double rate;                   ///< [Hz] of its readings
  double fastest = 0.0;          ///< [m/s] of a wheel, which it cannot exceed; 0: not known
  double counts_per_turn = 0.0;  ///< of a wheel; 0: each robot's own, base.counts_per_turn
  double wheel_radius = 0.0;     ///< [m] by its maker; 0: each robot's own
  double half_track = 0.0;       ///< [m] the same
  bool gyro = false;             ///< it sends the turn rate of its gyro
  double stops_after = 0.0;      ///< [s] without a speed it stops by itself; 0: never
  const char* at_hand = "";      ///< where it never does: what stops it while slamd is down
};

std::span<const BaseFacts> baseTable();
/// @return nullptr for a driver without a row
const BaseFacts* findBase(std::string_view driver);

}  // namespace slam
