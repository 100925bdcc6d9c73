// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/lidar/codec/rplidar_codec.hpp"

namespace slam::sim {

/// One entry of a unit's list of scan modes.
struct LidarMode {
  double sample_us = 508.0;  ///< [us] per sample
  rplidar::AnswerType answer = rplidar::AnswerType::kStandardNodes;
  std::string name;
  double max_distance = 12.0;    ///< [m]
  bool starts = true;            ///< else it is listed, but EXPRESS_SCAN with it is not answered
  std::uint8_t listed_type = 0;  ///< answer type as the list tells it; 0: the true one
};

/// Which unit an emulator is.
struct LidarIdentity {
  std::uint8_t model = 0x18;
  std::uint16_t firmware = 0x011D;  ///< high byte major, low byte minor
  std::uint8_t hardware = 7;
  std::uint16_t standard_us = 508, express_us = 254;  ///< [us] per sample, as GET_SAMPLERATE tells
  std::vector<LidarMode> modes{};                     ///< empty: no list (firmware below 1.24)
  std::uint16_t typical_mode = 0;
  bool accessory_board = false;  ///< motor by PWM; else by DTR, which a pseudo-terminal has not: always on
  int baud = 115200;             ///< [bit/s]
  double turn_rate = 5.5;        ///< [1/s]
};

/// Units of the field: A1M8 of today; what others reported of older firmware; an A2 on its accessory board.
LidarIdentity a1Firmware129();
LidarIdentity a1Firmware124();  ///< Standard, Express, Boost
LidarIdentity a1Firmware122();  ///< no list of modes
LidarIdentity a1Firmware120();  ///< no list, 476 us in both modes
LidarIdentity a1Firmware115();  ///< knows SCAN alone
LidarIdentity a2();
LidarIdentity a2m12();
LidarIdentity a3();
LidarIdentity c1();  ///< firmware 1.01, which is no old one: its series counts anew
LidarIdentity s1();  ///< the motor of the S units has a speed control
LidarIdentity s2();
LidarIdentity s3();
LidarIdentity s3WithUltraDense();  ///< newer firmware

/// Those that slam-sim plays, by name.
struct NamedIdentity {
  const char* name;
  LidarIdentity (*make)();
};
std::span<const NamedIdentity> namedIdentities();

}  // namespace slam::sim
