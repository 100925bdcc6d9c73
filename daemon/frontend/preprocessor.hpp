// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/pose_history.hpp"
#include "core/scan.hpp"
#include "estimation/ekf_timeline.hpp"
#include "frontend/dynamic_point_filter.hpp"
#include "frontend/interpreter/scan_interpreter.hpp"
#include "frontend/lidar_model.hpp"
#include "matching/deskew.hpp"
#include "matching/match_result.hpp"
#include "matching/normals.hpp"
#include "matching/scan_points.hpp"

namespace slam {

struct PreprocessorConfig {
  InterpreterConfig interpreter;
  NormalConfig normals;
  DynamicPointFilterConfig dynamic_points;
  double scan_moment = 0.5;  ///< [1] of a turn, when a scan's pose is found
};

/// A scan as the matchers take it.
struct Cloud {
  Timestamp stamp;                  ///< of the middle of the turn in the filters' time
  ScanPoints points;                ///< in base at `stamp`, with normals where a line was found
  Pose2 T_base_first;               ///< base at the first beam, seen from base at `stamp`
  MatchConfig match;                ///< settings for these points
  VisibilityTally walls;            ///< as DynamicPointFilter::walls()
  const LaserScan* scan = nullptr;  ///< as it was interpreted
  BodyShape body;                   ///< what is left out as moving with the robot, by the scan's bearings
};

/// Makes a scan's beams points: interpreted, deskewed to the middle of the turn, within the limits of range, with
/// normals.
class Preprocessor {
 public:
  /// @param body what moves with the robot, as last known
  Preprocessor(const PreprocessorConfig& config, const LidarModel& lidar, const MatchConfig& match,
               const BodyShape& body = {});

  /// @param first    stamp of the first beam in the filters' time
  /// @param interval [s] usual time between two scans; 0: not known yet
  /// @param filter   how the robot moved during the turn
  /// @param odometry the same by wheels and gyro alone
  /// @return         valid until the next call
  const Cloud& process(const LaserScan& recorded, Timestamp first, double interval, const EkfTimeline& filter,
                       const EkfTimeline& odometry);

  /// The robot may be anywhere.
  void forgetPlace() { dynamic_points_.forget(); }

  const ScanInterpreter& interpreter() const { return interpreter_; }
  /// Of the newest scan.
  int points() const { return static_cast<int>(cloud_.points.size()); }

 private:
  ScanInterpreter interpreter_;
  LidarModel lidar_;
  NormalConfig normals_;
  double scan_moment_;   // [1] of the turn
  double point_weight_;  // [1] at usual distances between beams
  DynamicPointFilter dynamic_points_;
  PoseHistory history_;
  BearingTable bearings_;
  Cloud cloud_;
};

}  // namespace slam
