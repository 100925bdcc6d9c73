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

namespace {

/// An A unit at 256000 bit/s on its accessory board, with 16000 samples a second.
LidarIdentity fastA(std::uint8_t model, double max_distance) {
  return {.model = model,
          .firmware = 0x011D,
          .hardware = 7,
          .standard_us = 250,
          .express_us = 125,
          .modes = {{250.0, AnswerType::kStandardNodes, "Standard", max_distance},
                    {125.0, AnswerType::kExpressCapsules, "Express", max_distance},
                    {62.5, AnswerType::kUltraCapsules, "Boost", max_distance},
                    {62.5, AnswerType::kUltraCapsules, "Sensitivity", max_distance},
                    {100.0, AnswerType::kUltraCapsules, "Stability", max_distance}},
          .typical_mode = 3,
          .accessory_board = true,
          .baud = 256000,
          .turn_rate = 10.0};
}

/// A C or an S unit: it lists a standard and a dense mode.
LidarIdentity withDenseBoost(std::uint8_t model, double standard_us, double dense_us, double max_distance, int baud) {
  return {.model = model,
          .firmware = 0x0102,
          .hardware = 18,
          .standard_us = static_cast<std::uint16_t>(standard_us),
          .express_us = static_cast<std::uint16_t>(dense_us),
          .modes = {{standard_us, AnswerType::kStandardNodes, "Standard", max_distance},
                    {dense_us, AnswerType::kDenseCapsules, "DenseBoost", max_distance}},
          .typical_mode = 1,
          .baud = baud,
          .turn_rate = 10.0};
}

}  // namespace

LidarIdentity a2m12() { return fastA(0x2C, 12.0); }
LidarIdentity a3() { return fastA(0x31, 25.0); }

LidarIdentity c1() {
  LidarIdentity unit = withDenseBoost(0x41, 200.0, 200.0, 40.0, 460800);  // it claims more than it can
  unit.firmware = 0x0101;
  unit.typical_mode = 0;
  return unit;
}

LidarIdentity s1() { return withDenseBoost(0x61, 217.0, 108.5, 40.0, 256000); }
LidarIdentity s2() { return withDenseBoost(0x71, 125.0, 31.25, 30.0, 1000000); }
LidarIdentity s3() { return withDenseBoost(0x81, 125.0, 31.25, 40.0, 1000000); }

LidarIdentity s3WithUltraDense() {
  LidarIdentity unit = s3();
  unit.firmware = 0x0103;
  unit.modes[1].answer = AnswerType::kUltraDenseCapsules;
  return unit;
}

std::span<const NamedIdentity> namedIdentities() {
  static constexpr NamedIdentity kNamed[] = {{"rplidar", a1Firmware129},
                                             {"a2", a2},
                                             {"a2m12", a2m12},
                                             {"a3", a3},
                                             {"c1", c1},
                                             {"s1", s1},
                                             {"s2", s2},
                                             {"s3", s3}};
  return kNamed;
}

}  // namespace slam::sim
