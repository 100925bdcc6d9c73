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

LidarIdentity c1() {
  return {.model = 0x41,
          .firmware = 0x0101,
          .hardware = 18,
          .standard_us = 200,
          .express_us = 200,
          .modes = {{200.0, AnswerType::kStandardNodes, "Standard", 16.0},
                    {200.0, AnswerType::kDenseCapsules, "DenseBoost", 16.0}},
          .typical_mode = 0,
          .baud = 460800};
}

LidarIdentity s3() {
  return {.model = 0x81,
          .firmware = 0x0102,
          .hardware = 18,
          .standard_us = 125,
          .express_us = 31,
          .modes = {{125.0, AnswerType::kStandardNodes, "Standard", 40.0},
                    {31.25, AnswerType::kDenseCapsules, "DenseBoost", 40.0}},
          .typical_mode = 1,
          .baud = 1000000};
}

}  // namespace slam::sim
