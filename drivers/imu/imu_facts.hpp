// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <memory>
#include <span>
#include <string_view>

#include "drivers/imu/imu_protocol.hpp"
#include "drivers/line_device.hpp"

namespace slam {

/// An IMU at a serial port, as a row of the table.
struct ImuFacts {
  static constexpr std::size_t kMostBauds = 8;

  const char* driver;      ///< word of imu.driver
  const char* name;        ///< in words
  LineDevice line_device;  ///< as others on the port know it
  std::unique_ptr<ImuProtocol> (*make)();
  std::array<int, kMostBauds> bauds;  ///< [bit/s] that units of it are set to, the usual ones first; 0s behind them
  double rate = 0.0;                  ///< [Hz] of its samples; 0: as each unit is set
  const char* silence = "";           ///< what to look at where it is silent, besides its power
  const char* output = "";            ///< what to switch on where it sends no turn rates

  std::size_t baudCount() const {
    std::size_t count = 0;
    while (count < bauds.size() && bauds[count] > 0) ++count;
    return count;
  }
};

std::span<const ImuFacts> imuTable();
/// @return nullptr for a driver without a row
const ImuFacts* findImu(std::string_view driver);

}  // namespace slam
