// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "core/timestamp.hpp"
#include "slam/back_end.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// What one keyframe or refresh changed.
struct MapUpdate {
  int first_in_map = 0;                       ///< keyframes before it are no part of the map any more
  std::vector<MapScan> scans;                 ///< to draw
  std::vector<Pose2> poses;                   ///< of keyframes 0, 1, ..., where known ones moved; empty: none did
  std::unique_ptr<MapCorrection> correction;  ///< for the front end, if one is due
  std::optional<EditedDrawing> edits;         ///< what they ask, where the keyframes that they are tied to moved
  std::optional<FloorFound> elsewhere;        ///< the other map that a lost robot was found in
  bool relocalised = false;                   ///< a lost robot was found in the map
  bool taken_back = false;                    ///< the session before was found, and lost before the map had it
  bool begun_anew = false;                    ///< a map of a few keyframes was forgotten
  bool loop_closed = false;
  Duration work{0};  ///< spent on it; 0 without a stopwatch
};

/// What an edit changed.
struct EditOutcome {
  Problem problem;             ///< why it was not made; none: it was
  int edit = 0;                ///< id of the one that came or went
  std::vector<MapScan> scans;  ///< to draw in the place of those before
  EditedDrawing drawing;
  std::vector<Outline> anew;  ///< [m] in map: whatever was drawn within them
};

/// The map's half of the pipeline: puts keyframes and depth images into the map, and gives what front end and Mapper
/// need to follow. A second correction is made only when the last one was given back.
///
/// No thread, clock or I/O. Allocates. Not safe for concurrent use.
class MapBuilder {
 public:
  /// @param map to go on in; without keyframes: an unknown place
  explicit MapBuilder(const BackEndConfig& config, const MapState& map = MapState(), Stopwatch stopwatch = nullptr);

  MapUpdate add(const Keyframe& keyframe);
  /// See BackEnd.
  void allowFor(std::int64_t scans) { back_end_.allowFor(scans); }
  /// @return what is to be drawn; nothing while the robot is lost, or in a map that is only given
  std::optional<MapView> add(const DepthObservation& sight) const { return back_end_.mapView(sight); }
  /// Makes or undoes an edit. @param robot [m] in map
  EditOutcome edit(const EditCommand& command, const Eigen::Vector2d& robot);
  /// Takes a correction back, applied or not.
  void recycle(std::unique_ptr<MapCorrection> used);

  /// Keyframes and what is drawn of them; where the robot is and how it is built are left to the caller.
  /// @param drawn_keyframes so many are in the grid
  MapState state(DrawnMap drawn, int drawn_keyframes) const;
  const BackEnd& backEnd() const { return back_end_; }

 private:
  BackEnd back_end_;
  Stopwatch stopwatch_;
  bool correction_away_ = false;
};

}  // namespace slam
