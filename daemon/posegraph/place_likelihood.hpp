// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <vector>

#include "posegraph/keyframe_graph.hpp"
#include "posegraph/wall_field.hpp"

namespace slam {

/// How probable a beam is where the map is right, and where it is not: density over the length at which it ends
/// [Thrun 2005, section 6.3], as far as the nearest wall tells it.
struct BeamModel {
  double sigma = 0.10;            ///< [m] of a wall's place in a map, and ...
  double sigma_per_metre = 0.02;  ///< [1] ... of that relative to the robot: a map is bent by so much
  double hit = 0.8;               ///< [1] share of the beams that end at a wall of the map
  double clutter_free = 0.03;     ///< [1/m] ends where the map saw nothing: people, chairs, doors
  double clutter_unknown = 0.15;  ///< [1/m] ends where the map has not looked: walls are some metres apart
  double gone = 0.1;         ///< [1] share of the map's walls that are no longer there: open doors, things taken away
  double correlation = 0.5;  ///< [m] of wall, all of which the map has or has not: it testifies once
};

/// What a segment saw, thinned so that each piece of wall counts once.
struct SegmentView {
  struct Ray {
    Eigen::Vector2d from, to, normal;  // [m] in the part's frame
    double range;                      // [m]
  };
  /// A stretch of the path, short enough to fit a bent map as it is.
  struct Part {
    Pose2 T_newest_part;
    std::vector<Ray> rays;
  };
  std::vector<Part> parts;   ///< newest first
  std::vector<int> part_of;  ///< by keyframe, newest first
  int rays = 0;
  double cell = 0.25;  ///< [m] of wall that gives one ray, the shortest

  /// @param length [m] of the newest path  @param part [m] of path
  void gather(const KeyframeGraph& keyframes, int oldest, int newest, double length, double part);
};

/// Compares what a segment saw with a place in the map: the path is laid there part by part, each matched to the map
/// and bound to the one before it as firmly as a map may be bent, and each piece of wall is judged by the beam model.
struct PlaceFit {
  Pose2 T_map_newest;
  double log_likelihood = 0.0;         ///< of independent pieces of wall, relative to all at their places
  double seen = 0.0;                   ///< [1] share of the rays that end at a wall of the map
  std::vector<Pose2> T_map_part = {};  ///< as laid, part by part
};
PlaceFit fitPlace(const WallField& field, const SegmentView& view, const Pose2& T_map_newest,
                  const BeamModel& model = {});

}  // namespace slam
