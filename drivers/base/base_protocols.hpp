// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "drivers/base/base_facts.hpp"

/// The makes of the table, each in a file of its own.
namespace slam {

/// ros_arduino_bridge: `e` at 50 Hz, `m` in between.
std::unique_ptr<BaseProtocol> makeArduinoProtocol(const BaseProtocolConfig& config);
/// iRobot Create 2, Roomba: asked once for a stream of sensor packets; driven in safe mode.
std::unique_ptr<BaseProtocol> makeCreateProtocol(const BaseProtocolConfig& config);
/// The reference firmware: it sends STATE unasked, and takes SPEEDS in counts per second.
std::unique_ptr<BaseProtocol> makeFrameProtocol(const BaseProtocolConfig& config);
/// Kobuki: it sends unasked, with stamps of its own; nothing is asked.
std::unique_ptr<BaseProtocol> makeKobukiProtocol(const BaseProtocolConfig& config);
/// TurtleBot3's OpenCR: its control table at 50 Hz, heartbeats and speeds in between.
std::unique_ptr<BaseProtocol> makeOpencrProtocol(const BaseProtocolConfig& config);
/// RoboClaw, motor 1 left: both counters at 50 Hz, both speeds in between.
std::unique_ptr<BaseProtocol> makeRoboclawProtocol(const BaseProtocolConfig& config);
/// Two VESCs, one at the port and one behind it on CAN: both tachometers at 50 Hz, both speeds in between.
std::unique_ptr<BaseProtocol> makeVescProtocol(const BaseProtocolConfig& config);

}  // namespace slam
