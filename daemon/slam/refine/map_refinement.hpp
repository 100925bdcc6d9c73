// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "slam/back_end_config.hpp"
#include "slam/map_state.hpp"
#include "slam/refine/wall_thickness.hpp"

namespace slam {

struct RefineConfig {
  double distance = 2.0;            ///< [m] from a keyframe within which another visit saw the same
  double apart = 5.0;               ///< [m] of path between two keyframes that are two visits: a chain of short ties
                                    ///< adds up the bias that a match has along a bare wall, the front end's does not
  double stretch = 2.0;             ///< [m] of a visit's path that is matched against as one: short enough to be rigid
  double longest_step = 2.0;        ///< [m] between keyframes in a row; where it is more, another drive begins
  int most_visits = 12;             ///< to which one keyframe is tied, the nearest ones
  int rounds = 3;                   ///< of matching at the poses that the one before left, and optimisation
  double window = 0.30;             ///< [m] a match that moves a keyframe further is none ...
  double window_turn = 0.1;         ///< [rad] ... or that turns it further
  double translation_sigma = 0.01;  ///< [m] floor of a tie's standard deviation
  double rotation_sigma = 0.003;    ///< [rad]
  int held_back = 10;  ///< of every so-manyth keyframe the ties count for nothing but the figures, which they check
  double least_gain = 0.01;  ///< [1] by which what visits differ by has to fall; walls may not get thicker
  double matching = 0.7;     ///< [1] of the time goes into the rounds, the rest into the drawing of the result
  WallThicknessConfig walls = {};
};

/// What can be measured of a map without a truth. All of it falls where the poses get better.
struct MapFigures {
  double wall_thickness = 0.0;  ///< [m] see wallThickness()
  double revisits = 0.0;        ///< [m] RMS of what visits to a place lie off from how they match
  double held_back = 0.0;       ///< [m] the same of those that have no say in the poses
};

/// How a refinement went.
struct RefineReport {
  enum class Outcome : std::uint8_t {
    kRefined,
    kNoKeyframes,  ///< fewer than two in the map
    kFloorPlan,    ///< which has no scans
    kNoRevisits,   ///< too few places were seen twice for a figure
    kNoBetter,     ///< the figures do not fall
  } outcome = Outcome::kNoRevisits;
  MapFigures before, after;
  int compared = 0;  ///< pairs of a keyframe and another visit to its place, at the end
  int verified = 0;  ///< of these, which match
  int revoked = 0;   ///< of these, which the others contradict
};

struct RefinedMap {
  std::optional<MapState> map;  ///< if outcome is kRefined
  RefineReport report;
};

/// Computes a map once more from all that its keyframes hold. Each one is matched with every other visit to its place,
/// as a loop closure is; the whole graph with all of these ties is optimised, and again from there. Then the map is
/// measured as before, and drawn anew only where it got better. Frame, edits, places and calibration stay.
/// Neither the lidar's mount nor the wheels' scale is estimated: keyframes hold poses that both have gone into.
/// @param progress is called with the share [1] that is done
RefinedMap refineMap(const MapState& map, const BackEndConfig& config, const OccupancyGridConfig& grid,
                     const RefineConfig& refine = {}, const std::function<void(double)>& progress = {});

}  // namespace slam
