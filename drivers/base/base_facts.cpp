// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/base_facts.hpp"

#include <array>

#include "drivers/base/base_protocols.hpp"
#include "drivers/search/driver_row.hpp"
#include "firmware_if/arduino_bridge.hpp"
#include "firmware_if/create_oi.hpp"
#include "firmware_if/kobuki.hpp"
#include "firmware_if/opencr.hpp"
#include "firmware_if/roboclaw.hpp"
#include "firmware_if/slamd_base/base_frame.hpp"
#include "firmware_if/vesc/vesc_packets.hpp"

namespace slam {
namespace {

constexpr std::array kTable = {
    BaseFacts{.driver = "text",
              .name = "an Arduino with ros_arduino_bridge",
              .line_device = LineDevice::kArduino,
              .make = makeArduinoProtocol,
              .baud = arduino_bridge::kBaud,
              .counter_bits = 32,
              .rate = 50.0,
              .stops_after = arduino_bridge::kAutoStop},
    BaseFacts{.driver = "create",
              .name = "an iRobot Create 2 or Roomba",
              .line_device = LineDevice::kCreate,
              .make = makeCreateProtocol,
              .baud = create_oi::kBaud,
              .counter_bits = 16,
              .rate = create_oi::kStreamRate,
              .fastest = create_oi::kFastest,
              .counts_per_turn = create_oi::kCountsPerTurn,
              .wheel_radius = create_oi::kWheelRadius,
              .half_track = create_oi::kHalfTrack,
              .at_hand = "keep its CLEAN button within reach: pressed, it stops the robot"},
    BaseFacts{.driver = "kobuki",
              .name = "a Kobuki",
              .line_device = LineDevice::kKobuki,
              .make = makeKobukiProtocol,
              .baud = kobuki::kBaud,
              .counter_bits = 16,
              .rate = kobuki::kFeedbackRate,
              .fastest = kobuki::kFastest,
              .counts_per_turn = kobuki::kCountsPerTurn,
              .wheel_radius = kobuki::kWheelRadius,
              .half_track = kobuki::kHalfTrack,
              .gyro = true,
              .stops_after = kobuki::kWatchdog},
    BaseFacts{.driver = "frame",
              .name = "a base with the reference firmware",
              .line_device = LineDevice::kFrameBase,
              .make = makeFrameProtocol,
              .baud = slamd_base::kBaud,
              .counter_bits = 32,
              .rate = slamd_base::kStateRate,
              .gyro = true,
              .stops_after = 1e-3 * slamd_base::kCommandLasts},
    BaseFacts{.driver = "roboclaw",
              .name = "a RoboClaw",
              .line_device = LineDevice::kRoboclaw,
              .make = makeRoboclawProtocol,
              .baud = roboclaw::kBaud,
              .counter_bits = 32,
              .rate = 50.0,
              .stops_after = 0.1 * roboclaw::kTenths},
    BaseFacts{.driver = "opencr",
              .name = "a TurtleBot3 with OpenCR",
              .line_device = LineDevice::kOpencr,
              .make = makeOpencrProtocol,
              .baud = opencr::kBaud,
              .counter_bits = 32,
              .rate = 50.0,
              .counts_per_turn = opencr::kCountsPerTurn,
              .gyro = true,
              .stops_after = opencr::kHeartbeatLasts},
    BaseFacts{.driver = "vesc",
              .name = "two VESCs",
              .line_device = LineDevice::kVesc,
              .make = makeVescProtocol,
              .baud = vesc::kBaud,
              .counter_bits = 32,
              .rate = 50.0,
              .stops_after = vesc::kTimeout},
};

}  // namespace

std::span<const BaseFacts> baseTable() { return kTable; }

const BaseFacts* findBase(std::string_view driver) { return rowOfDriver(baseTable(), driver); }

}  // namespace slam
