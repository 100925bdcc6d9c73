// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_identity.hpp"

namespace slam::sim {

using rplidar::AnswerType;

LidarIdentity a1Firmware129() {
  return {.modes = {{508.0, AnswerType::kStandardNodes, "Standard"},
                    {254.0, AnswerType::kExpressCapsules, "Express"},
                    {127.0, AnswerType::kUltraCapsules, "Boost"},
                    {127.0, AnswerType::kUltraCapsules, "Sensitivity"},
                    {201.0, AnswerType::kUltraCapsules, "Stability"}},
          .typical_mode = 3};
}

LidarIdentity a1Firmware124() {
  LidarIdentity unit = a1Firmware129();
  unit.firmware = 0x0118;
  unit.hardware = 5;
  unit.modes.resize(3);
  unit.typical_mode = 2;
  return unit;
}

LidarIdentity a1Firmware122() { return {.firmware = 0x0116, .hardware = 4}; }

LidarIdentity a1Firmware120() { return {.firmware = 0x0114, .hardware = 0, .standard_us = 476, .express_us = 476}; }

LidarIdentity a1Firmware115() { return {.firmware = 0x010F, .hardware = 0, .standard_us = 476, .express_us = 476}; }

LidarIdentity a2() {
  LidarIdentity unit = a1Firmware129();
  unit.model = 0x28;
  unit.hardware = 5;
  unit.accessory_board = true;
  return unit;
}

}  // namespace slam::sim
