// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/sim/robot/robot_model.hpp"

namespace slam::sim {

/// What a gyro, or the node that reads it, does wrong.
struct GyroFault {
  double offset = 0.0;                                    ///< [rad/s] about the vertical
  double clip = std::numeric_limits<double>::infinity();  ///< [rad/s] largest rate that is reported
  double step = 0.0;                                      ///< [rad/s] of the values; 0: as fine as the sensor's
  bool degrees = false;                                   ///< values in deg/s
  bool down = false;                                      ///< mounted upside down, about its x axis

  ImuReading apply(ImuReading reading) const {
    if (offset != 0.0) reading.gyro[2] += offset;  // -0.0 stays
    if (down) {
      for (const std::size_t axis : {1U, 2U}) {
        reading.gyro[axis] = -reading.gyro[axis];
        reading.accel[axis] = -reading.accel[axis];
      }
    }
    for (double& rate : reading.gyro) {
      rate = std::clamp(rate, -clip, clip);
      if (step > 0.0) rate = step * std::round(rate / step);
      if (degrees) rate *= 180.0 / std::numbers::pi;
    }
    return reading;
  }
};

}  // namespace slam::sim
