// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/pose_history.hpp"
#include "core/scan.hpp"
#include "estimation/ekf_timeline.hpp"
#include "frontend/front_end_config.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// A scan as the matchers take it.
struct Cloud {
  Timestamp stamp;     ///< of the middle of the turn in the filters' time
  ScanPoints points;   ///< in base at `stamp`, with normals where a line was found
  Pose2 T_base_first;  ///< base at the first beam, seen from base at `stamp`
  MatchConfig match;   ///< settings for these points
};

/// Makes a scan's beams points: deskewed to the middle of the turn, within the limits of range, with normals.
class Preprocessor {
 public:
  explicit Preprocessor(const FrontEndConfig& config);

  /// @param first  when the first beam was measured, in the filter's time
  /// @param filter how the robot moved during the turn
  /// @return       valid until the next call
  const Cloud& process(const LaserScan& scan, Timestamp first, const EkfTimeline& filter);

 private:
  LidarModel lidar_;
  NormalConfig normals_;
  double scan_moment_;   // [1] of the turn
  double point_weight_;  // [1] at usual distances between beams
  PoseHistory history_;
  Cloud cloud_;
};

}  // namespace slam
