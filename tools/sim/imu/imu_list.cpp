// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <stdexcept>

#include "drivers/search/driver_row.hpp"
#include "tools/sim/board/imu_emulator.hpp"
#include "tools/sim/imu/emulated_imu.hpp"
#include "tools/sim/imu/imu_emulators.hpp"

namespace slam::sim {
namespace {

std::unique_ptr<EmulatedImu> makeA9() { return std::make_unique<ImuEmulator>(ImuEmulator::Framing::kA9); }

struct Row {
  const char* driver;
  std::unique_ptr<EmulatedImu> (*make)();
};
constexpr std::array kRows = {Row{"hfi", makeA9}, Row{"bno08x", makeBno08x}, Row{"witmotion", makeWitmotion},
                              Row{"xsens", makeXsens}};

}  // namespace

std::unique_ptr<EmulatedImu> makeImu(std::string_view driver) {
  const Row* row = rowOfDriver<Row>(kRows, driver);
  if (row == nullptr) throw std::invalid_argument("no IMU " + std::string(driver) + " is simulated");
  return row->make();
}

std::vector<std::string> imuNames() {
  std::vector<std::string> names;
  for (const Row& row : kRows) names.emplace_back(row.driver);
  return names;
}

}  // namespace slam::sim
