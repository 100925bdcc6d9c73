// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "tools/calibrate/sensor_log.hpp"

namespace slam {

struct GyroScale {
  double value = 1.0;  ///< [1] what the gyro turns while the scans turn by 1; negative: it is mounted upside down
  double sigma = 0.0;  ///< [1]
  double bias = 0.0;   ///< [rad/s] reading at rest
};

/// Scale and bias of the gyro by the turns of the matched scans: least squares of
/// gyro's turn = value * scans' turn + bias * time  over spans of a second, without the spans that fit worst.
/// @return std::nullopt: there is no gyro in the log, or the robot hardly turned
std::optional<GyroScale> gyroScale(const SensorLog& log);

}  // namespace slam
