// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "slam/back_end_config.hpp"
#include "slam/map_state.hpp"
#include "slam/merge/cell_agreement.hpp"
#include "slam/merge/map_registration.hpp"
#include "slam/merge/moved_furniture.hpp"

namespace slam {

struct MergeConfig {
  MapRegistrationConfig registration;  ///< its places are those of the back end
  double closure_spacing = 0.5;        ///< [m] of the second map's path between two closures
  double closure_distance = 1.0;       ///< [m] from a keyframe of the first map, within which both saw the same
  double min_verified = 0.75;          ///< [1] of the keyframes so near that match, and are not revoked
  double consistent_within = 5.0;      ///< [m] two closures so near to each other in the second map ...
  double consistency = 0.03;           ///< [m] ... agree when they differ by less over the way between them ...
  double bend = 0.01;                  ///< [1] ... and that share of it ...
  double consistent_turn = 0.02;       ///< [rad] ... and by no more turn; one with which most disagree is revoked
  double max_revoked = 0.2;            ///< [1] of the closures that the others contradict
  double compared_cell = 0.05;         ///< [m] of the grids of either map, whose occupied cells are compared ...
  double cell_tolerance = 0.15;        ///< [m] ... and are the same when they are no farther apart
  /// [1] of these cells are the same, at least, where the furniture stayed: 0.994 to 1.000. On two floors of one
  /// building it is 0.82 to 0.94, in a home where all furniture was moved 0.90 to 0.96. There ...
  double min_same_cells = 0.96;
  MovedFurnitureConfig furniture;
  double min_moved = 1.0;        ///< [m] ... the shapes of what differs decide: MovedFurniture::evidence
  bool furniture_moved = false;  ///< as a person knows: less agreement is no sign of another floor
};

/// How a merge went.
struct MergeReport {
  enum class Outcome : std::uint8_t {
    kMerged,
    kNoKeyframes,     ///< of one of the maps, or it is a floor plan
    kShared,          ///< both hold the same keyframes
    kTooManyEdits,    ///< more than a map may have
    kNowhere,         ///< the second map was not found in the first
    kAmbiguous,       ///< two places of it fit
    kContradictory,   ///< some of it fits at one place, some at another, or it does not match there
    kOtherFurniture,  ///< the walls are the same: another floor, or furniture that does not look as if it was moved
  } outcome = Outcome::kNowhere;
  RegisteredMap registration;
  int near = 0;              ///< keyframes of the second map that were compared with ones of the first near them
  int verified = 0;          ///< of these, which match
  int revoked = 0;           ///< of these, whose closures the others contradict
  double residual = 0.0;     ///< [m] RMS of what the closures that stand miss after the optimisation
  CellAgreement cells;       ///< of both maps where they lie at last
  MovedFurniture furniture;  ///< where too few of these are the same
};

struct MergedMap {
  std::optional<MapState> map;  ///< if outcome is kMerged
  MergeReport report;
};

/// Merges two maps. The second one is registered in the first; each of its keyframes near one of the first is matched
/// there as a loop closure is, and both pose graphs are optimised as one. The first one's frame, last pose, calibration
/// and cells are those of the merged map; edits and places of both are kept.
/// @param progress is called with the share [1] that is done
MergedMap mergeMaps(const MapState& first, const MapState& second, const BackEndConfig& config,
                    const OccupancyGridConfig& grid, MergeConfig merge = {},
                    const std::function<void(double)>& progress = {});

/// Both maps as one, the second one laid where it may be in the first, as it is.
MapState jointMap(const MapState& first, const MapState& second, const Pose2& T_first_second,
                  const OccupancyGridConfig& grid);

}  // namespace slam
