// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "graph/keyframe_graph.hpp"
#include "relocalisation/decay_rate_map.hpp"

namespace slam {

/// What a session saw, thinned so that each piece of wall counts once.
struct QueryCloud {
  struct Ray {
    Eigen::Vector2d from, to, normal;  // [m] in the part's frame
    double range;                      // [m]
  };
  /// What a stretch of the path saw near it, or in some distance: small enough to fit a bent map as it is.
  struct Part {
    Pose2 T_newest_part;
    std::vector<Ray> rays;
    int beside = -1;           ///< part that the map can be bent against; -1: none
    double least_range = 0.0;  ///< [m] of its rays
  };
  std::vector<Part> parts;   ///< newest first, then those in a distance
  std::vector<int> part_of;  ///< by keyframe, newest first
  int rays = 0;
  double cell = 0.25;  ///< [m] of wall that gives one ray, the shortest

  /// [1] Independent pieces of wall that a ray stands for.
  double weight(const BeamModel& model) const { return std::min(1.0, cell / model.correlation); }

  /// @param length [m] of the newest path  @param part [m] of path
  /// @param rigid_range [m] what lies further, or twice as far, is a part of its own; 0: however far
  void gather(const KeyframeGraph& keyframes, int oldest, int newest, double length, double part, double rigid_range);
  /// The same, were all its ways and ranges longer.
  QueryCloud scaled(double scale) const;

 private:
  void splitByRange(double rigid_range);
};

struct PlaceFitConfig {
  /// Offsets that are tried.
  struct Steps {
    int reach;    ///< to each side
    double step;  ///< [m]
    int turns;    ///< to each side
    double turn;  ///< [rad]
  };
  double same_face = 0.2;  ///< cosine: a point and a wall whose normals differ by more are two faces
  Eigen::Vector3d search_sigma{0.3, 0.3, 0.05};  ///< [m, m, rad] of a place that the search found
  Eigen::Vector3d bend_sigma{0.1, 0.1, 0.03};    ///< [m, m, rad] of the map's bend, from part to part of the path
  Eigen::Vector3d ahead_sigma{0.1, 0.1, 0.015};  ///< [m, m, rad] ... and to what was seen in a distance
  double bent_per_metre = 0.02;                  ///< [1] of what is seen of a part, before it is laid
  int iterations = 8;                            ///< of laying a part
  double settled = 0.005;                        ///< [m] at one metre: a step below this is the last
  double through = 0.5;  ///< [1] of a wall: a beam that went through more did not end at the map's first wall
  Steps together{2, 0.2, 1, 0.01};
  Steps together_fine{1, 0.1, 1, 0.005};
  Steps ahead{2, 0.1, 2, 0.005};
};

/// Compares what a session saw with a place in the map: it is laid there part by part, each matched to the map and
/// bound to the one beside it as firmly as a map may be bent; all of it is moved to where its beams end most
/// likely; and what they ended at and went through is judged by the beam model.
struct PlaceFit {
  Pose2 T_map_newest;
  double log_likelihood = 0.0;  ///< of independent pieces of wall, up to a constant of the session
  double seen = 0.0;            ///< [1] share of the rays that end at a wall of the map, with none before it
  double scale = 1.0;           ///< [1] of the view that fits, against what the robot measured
};
PlaceFit fitPlace(const DecayRateMap& field, const QueryCloud& view, const Pose2& T_map_newest,
                  const PlaceFitConfig& config = {});

}  // namespace slam
