// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <iosfwd>

#include "config/config.hpp"
#include "tools/calibrate/calibration.hpp"

namespace slam {

/// A value that the drive contradicts.
struct CalibratedValue {
  const char* key;
  const char* unit;
  double configured = 0.0, estimated = 0.0;
  double interval = 0.0;  ///< half of the 95 % interval
  bool is_wrong = false;  ///< configured is outside of the interval, and off by what matters
};

struct DriveCalibration {
  std::vector<CalibratedValue> values;  ///< that the drive determines
  std::string open;                     ///< why some are not determined, and how to drive; empty: all are
  double translation_before = 0.0, translation_after = 0.0;  ///< [m] RMS of a motion: scans over wheels
  double rotation_before = 0.0, rotation_after = 0.0;        ///< [rad]
  double gyro_scale = 0.0, gyro_interval = 0.0;              ///< [1] gyro's turns over the scans'; 0: no gyro
  int used = 0, rejected = 0;                                ///< motions
};

/// slam-calibrate's estimate from a recorded drive, with `config` before it. What is significantly wrong is set in
/// `config`. A lidar that sat elsewhere bends the scans: the log is matched again with each better place.
/// @throws std::runtime_error where the drive is too short, or wheels and scans contradict each other
DriveCalibration calibrateDrive(Config& config, const std::filesystem::path& log);

/// A table of it for people.
void print(const DriveCalibration& calibration, std::ostream& out);

}  // namespace slam
