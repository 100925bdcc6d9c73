// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "slam/edits/map_edit.hpp"

namespace slam {

/// What a person asks of the edits of a map.
struct EditCommand {
  enum Kind : std::uint8_t { kAdd, kUndo, kRedo, kRemove } kind = kAdd;
  EditRequest request;     ///< of kAdd
  int id = 0;              ///< of kRemove
  std::int64_t utime = 0;  ///< [us since the epoch]
};

/// All edits of a map, with what was done to them, so that it can be undone and done again.
struct MapEdits {
  struct Step {
    int id = 0;            ///< of the edit
    bool removes = false;  ///< else it was made
  };
  std::vector<MapEdit> edits;  ///< in effect, or they may come back; by rising id
  std::vector<Step> steps;
  std::size_t done = 0;  ///< so many of the steps; the others were undone
  int made = 0;          ///< id of the newest edit ever made
  int revision = 0;      ///< counts up with each step, there and back
  /// Scans of keyframes before points were erased, by keyframe. Not stored: those are the ones that the map stores.
  std::map<int, std::shared_ptr<const StoredScan>> whole;

  bool empty() const { return made == 0; }
  MapEdit* find(int id);
  /// Makes an edit, or takes a step. @param concerned out: the edit that came or went; 0: none
  /// @return why not; none: it is done
  Problem carryOut(const EditCommand& command, const KeyframeGraph& keyframes, std::span<const char> in_map,
                   int* concerned);
  /// Takes over the edits of another map, whose keyframes count from `first` on in this one and whose axes are turned
  /// by `turn` [rad] in it. What was undone in either is forgotten.
  void append(const MapEdits& other, int first, double turn);

 private:
  Problem add(const EditCommand& command, const KeyframeGraph& keyframes, std::span<const char> in_map);
  void take(Step step);
  void forgetUndone();
};

/// [m, m, rad] of a place, in the axes of a frame in which its own are turned by so much [rad].
Eigen::Vector3d turnedSigma(const Eigen::Vector3d& sigma, double turn);

/// Makes the scans of a map such as its edits ask. @param keyframes with whole scans, or those that this gave
/// @return ids of the keyframes whose points changed
std::vector<int> eraseFrom(KeyframeGraph& keyframes, MapEdits& edits);
/// What the edits ask of the drawing.
EditedDrawing drawingOf(const MapEdits& edits, const KeyframeGraph& keyframes, std::span<const char> in_map);
/// [1] share of the points around a place [m, in map] that an erase would leave. @param edit that is not made yet
double shareLeft(const MapEdit& edit, const KeyframeGraph& keyframes, const Eigen::Vector2d& robot);

}  // namespace slam
