// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slam {

/// What was read of one sensor: rows are lines, messages or records, as the format has them.
struct SensorRows {
  std::string name;        ///< as the recording names it: kind of line, channel, topic
  std::string frame = {};  ///< in which the sensor measures; empty: the recording does not say
  int used = 0;
  int refused = 0;
  std::map<std::string, int> reasons = {};                        ///< why rows were refused, and how many each
  std::int64_t first = std::numeric_limits<std::int64_t>::max();  ///< [us] stamps of the rows that were used
  std::int64_t last = std::numeric_limits<std::int64_t>::min();

  void use(std::int64_t utime);
  /// Too few of its rows were understood to trust them.
  bool doubtful() const { return used < refused; }
};

/// How the recording's robot is built, as far as it is known: what its configuration says. An empty value is not known,
/// and slamd's default holds.
struct RobotDescription {
  double lidar_x = 0.0, lidar_y = 0.0, lidar_yaw = 0.0;  ///< T_base_lidar [m, m, rad]
  bool lidar_upside_down = false;
  std::string mount_source = {};  ///< where the mount is from; empty: the recording does not say
  std::optional<double> range_min = {}, range_max = {}, range_sigma = {};  ///< [m]
  std::optional<double> wheel_radius = {}, half_track = {};                ///< [m]
};

/// What a conversion found in its input, used and could not use. The log is written beside it (LogOutput).
struct Recording {
  int scans = 0, wheels = 0, imu = 0;
  int poses = 0;                    ///< of a reference trajectory, written apart
  int rejected = 0;                 ///< records that were not understood
  std::string first_rejection;      ///< where and why, of the first
  std::string format;               ///< in words, for the report
  std::deque<SensorRows> sensors;   ///< references stay
  std::vector<std::string> unused;  ///< what else is in it, and why it is not used
  std::vector<std::string> notes;   ///< what a person should know
  RobotDescription robot;
  std::optional<std::string> configuration;  ///< that the recording brings: written as it is

  /// The sensor of this name, made where there is none.
  SensorRows& sensor(const std::string& name);
  void reject(const std::string& where, const std::string& why) {
    if (rejected++ == 0) first_rejection = where + ": " + why;
  }
  void reject(SensorRows& rows, const std::string& where, const std::string& why);

  /// @param count of samples of this kind, which is one more
  void use(SensorRows& rows, int Recording::*count, std::int64_t utime) {
    rows.use(utime);
    ++(this->*count);
  }

  /// @return what to say where less than half of a sensor's rows could be used, or nothing at all; empty: all is well
  std::string doubt() const;
};

/// One line that sums up, and with `details` a table of the sensors and what was not used.
std::string reportText(const Recording& recording, const std::string& out, bool details);

/// slamd's configuration for the log: TOML with what differs from the defaults, or that the recording brings.
std::string configText(const Recording& recording, const std::string& made_by);

/// @throws std::runtime_error when the file cannot be written
void writeConfig(const Recording& recording, const std::string& made_by, const std::filesystem::path& file);

}  // namespace slam
