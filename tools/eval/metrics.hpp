// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tools/common/trajectory.hpp"

namespace slam {

struct MeanAndDeviation {
  double mean = 0.0, deviation = 0.0;
};
MeanAndDeviation meanAndDeviation(const std::vector<double>& values);

/// A relative pose that is known [Kümmerle et al., "On measuring the accuracy of SLAM algorithms", 2009].
struct Relation {
  Timestamp from, to;
  Pose2 T_from_to;
};

/// Rows `t1 t2 x y z roll pitch yaw`. @throws std::runtime_error with file and line
std::vector<Relation> readRelations(const std::filesystem::path& file);

/// Errors relation^-1 * (pose(t1)^-1 * pose(t2)).
struct RelationErrors {
  MeanAndDeviation translation;          ///< [m] length
  MeanAndDeviation rotation;             ///< [deg] absolute
  MeanAndDeviation squared_translation;  ///< [m^2]
  MeanAndDeviation squared_rotation;     ///< [deg^2]
  int used = 0, left_out = 0;            ///< rows; left out: outside the trajectory's time
};
RelationErrors relationErrors(const Trajectory& trajectory, const std::vector<Relation>& relations);

/// Absolute trajectory error after the rigid motion that aligns the two best [Umeyama 1991], at the estimate's stamps.
struct AteErrors {
  double rmse = 0.0, mean = 0.0, max = 0.0;  ///< [m]
  double rotation_mean = 0.0;                ///< [deg]
  Pose2 T_truth_estimate;
  int used = 0, left_out = 0;
};
AteErrors absoluteErrors(const Trajectory& estimate, const Trajectory& truth, bool align = true);

/// Errors at the stamps of a few true poses, in the files' own frames.
struct WaypointErrors {
  std::vector<double> position;  ///< [m] one a waypoint, in their order
  std::vector<double> heading;   ///< [deg] absolute
  int left_out = 0;              ///< outside the estimate's time
};
WaypointErrors waypointErrors(const Trajectory& estimate, const Trajectory& waypoints);

}  // namespace slam
