// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "tools/calibrate/calibration.hpp"

namespace slam {

/// What slam-calibrate prints.
struct CalibrationReport {
  RobotGeometry configured;
  Calibration result;           ///< of status kDone or kPartly
  bool angles_recorded = true;  ///< false: wheel angles were taken back from the dead reckoning

  /// Human table, what to know of it in words, and the lines for slamd.toml.
  std::string table() const;
  std::string json() const;
};

}  // namespace slam
