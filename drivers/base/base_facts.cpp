// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/base_facts.hpp"

#include <array>

#include "drivers/base/arduino_base.hpp"
#include "drivers/base/create_base.hpp"
#include "drivers/base/kobuki_base.hpp"
#include "drivers/search/driver_row.hpp"
#include "firmware_if/arduino_bridge.hpp"
#include "firmware_if/create_oi.hpp"
#include "firmware_if/kobuki.hpp"

namespace slam {
namespace {

constexpr std::array kTable = {
    BaseFacts{.driver = "text",
              .name = "an Arduino with ros_arduino_bridge",
              .speaker = Speaker::kArduino,
              .make = makeArduinoProtocol,
              .baud = arduino_bridge::kBaud,
              .counter_bits = 32,
              .rate = 50.0},
    BaseFacts{.driver = "create",
              .name = "an iRobot Create 2 or Roomba",
              .speaker = Speaker::kCreate,
              .make = makeCreateProtocol,
              .baud = create_oi::kBaud,
              .counter_bits = 16,
              .rate = create_oi::kStreamRate,
              .fastest = create_oi::kFastest,
              .counts_per_turn = create_oi::kCountsPerTurn,
              .wheel_radius = create_oi::kWheelRadius,
              .half_track = create_oi::kHalfTrack},
    BaseFacts{.driver = "kobuki",
              .name = "a Kobuki",
              .speaker = Speaker::kKobuki,
              .make = makeKobukiProtocol,
              .baud = kobuki::kBaud,
              .counter_bits = 16,
              .rate = kobuki::kFeedbackRate,
              .fastest = kobuki::kFastest,
              .counts_per_turn = kobuki::kCountsPerTurn,
              .wheel_radius = kobuki::kWheelRadius,
              .half_track = kobuki::kHalfTrack,
              .gyro = true},
};

}  // namespace

std::span<const BaseFacts> baseTable() { return kTable; }

const BaseFacts* findBase(std::string_view driver) { return rowOfDriver(baseTable(), driver); }

}  // namespace slam
