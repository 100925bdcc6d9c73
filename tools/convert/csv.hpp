// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "tools/convert/recording.hpp"

namespace slam {

/// Tables with a row for each sample, all on one clock; an empty path is left out. A first line of names is a header.
struct CsvInput {
  /// Ranges, with or without a stamp before them: in metres, or raw words of a SICK (range_cm = word & 8191, 8191:
  /// none, from -90 deg in equal steps). A header names the columns: t or a name with "time" or "stamp"; r0, range_1,
  /// ... or bearings [deg] for the ranges; x, y, theta for the odometry; angle_min, angle_max, angle_increment [rad].
  std::filesystem::path scans = {};
  std::filesystem::path speed = {};     ///< t_s,v_m_s
  std::filesystem::path imu = {};       ///< t_s | stamp_s, ax_g..az_g, wx_rad_s..wz_rad_s
  std::filesystem::path encoders = {};  ///< stamp_s, front right, front left, rear right, rear left ticks per interval
  double metres_per_tick = 0.0022168;   ///< of the encoders (254 mm wheel, 360 counts a turn)
  double wheel_radius = 0.127;          ///< [m] of the encoders' wheels
  double half_track = 0.44;             ///< [m] of the encoders' base: half its effective track
  double imu_sign_z = 1.0;              ///< -1 where the IMU's z axis points down
  std::string unit = {};                ///< of the ranges: "m", "cm", "mm", "words"; empty: found from the data
  std::string stamp_column = {};        ///< name, or number from 1; empty: found from the header or the data
  std::string first_range = {};         ///< column of the first range, as above; all behind it are ranges
  std::optional<double> field_of_view =
      {};  ///< [deg] from the first beam to the last, ahead in its middle; below 0: clockwise
  std::optional<double> first_bearing = {};  ///< [deg] counter-clockwise from ahead
  std::optional<double> period = {};         ///< [s] between scans without stamps
};

/// @throws std::runtime_error when an input cannot be opened, holds no sample, or the output cannot be written
Recording convertCsv(const CsvInput& in, const std::filesystem::path& out);

}  // namespace slam
