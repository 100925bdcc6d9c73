// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/faults/sensor_faults.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim {

/// Bearings at which the lidar sees the robot itself.
struct BodyArc {
  double middle = 0.0, half_width = 0.0;  ///< [rad] in the lidar's frame, counter-clockwise
  double range = 0.0;                     ///< [m]
};

/// What is written for a beam without return: one of these ranges, drawn.
struct NoReturn {
  std::vector<float> ranges = {0.0F};  ///< [m]
  bool beyond_reach = false;           ///< counted from the lidar's reach
};

struct TimeSpan {
  double begin = 0.0, end = 0.0;  ///< [s] since the drive began
  bool contains(double time) const { return time >= begin && time < end; }
};

/// Someone carries the robot to another place of its route and puts it down there, turned anyhow.
struct Kidnapping {
  static constexpr double kSeconds = 3.0;  ///< that the robot is in the air

  double time = 0.0;     ///< [s] since the drive began
  bool covered = false;  ///< nothing comes back to the lidar meanwhile
};

/// What is unlike an ordinary drive in an empty home with sound sensors.
struct Situation {
  std::vector<BodyArc> bodies = {};
  std::optional<double> floor_line = {};  ///< [m] ahead of the lidar, across; a tilted lidar sees it
  bool cart = false;                      ///< towed
  enum class Follower { kNone, kRigid, kSwaying } follower = Follower::kNone;
  int walkers = 0;             ///< around the robot
  int glass = 0, mirrors = 0;  ///< pieces of wall

  LidarErrors lidar = {};
  int beams = 360;                               ///< in the field of view
  double field_of_view = 6.283185307179586;      ///< [rad] about straight ahead
  double turn_rate = LidarModel::kTurnRate;      ///< [1/s]
  std::optional<double> claimed_range_max = {};  ///< [m] in the scans, where it is not the lidar's
  bool beam_times = true;
  NoReturn no_return = {};
  double range_bias = 0.0;                  ///< [m] that is added to each range, and ...
  double range_scale = 0.0;                 ///< [1] ... share of it
  double bearing_scale = 0.0;               ///< [1] by which beams lie further apart than they are written
  Pose2 mount_error = {};                   ///< from where the lidar is taken to sit to where it does
  std::optional<double> second_lidar = {};  ///< [rad] by which a second one, merged with the first, is turned unknown

  ImuFault imu = {};
  std::optional<TimeSpan> wheels_away = {};
  std::optional<TimeSpan> wheels_dead = {};  ///< their counters stand
  bool starts_moving = false;                ///< the log begins while the robot drives, and it never pauses
  std::optional<Kidnapping> kidnapping = {};

  SceneVariant scene = {};
};

/// Adds what KIND=VALUE says.
/// @throws std::invalid_argument with the known kinds for an unknown one, with its unit and meaning for a bad value
void addTo(Situation& situation, std::string_view kind_and_value);

/// One line a kind: its form with units, and its meaning.
std::string situationKinds();

}  // namespace slam::sim
