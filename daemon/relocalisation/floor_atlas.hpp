// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "graph/keyframe_graph.hpp"

namespace slam {

/// A map that the robot may be in instead of the present one, such as that of another floor.
struct FloorMap {
  std::string name;
  KeyframeGraph keyframes;
  std::vector<char> in_map;  ///< by keyframe
};

/// The maps that a lost robot is searched in together.
struct Floors {
  std::string present;                                  ///< name of the map that the robot goes on in
  std::vector<std::shared_ptr<const FloorMap>> others;  ///< none: it is searched in the present one alone

  /// By number: 0 is the present one.
  const std::string& name(int floor) const {
    return floor == 0 ? present : others[static_cast<std::size_t>(floor) - 1]->name;
  }
};

/// Another map, in which a lost robot was found.
struct FloorFound {
  std::string name;
  std::int32_t session = 0;
  Pose2 T_floor_session;  ///< frame of the session, as its keyframes have it, in that map
};

/// Several maps side by side in one frame, so that one search compares the places of each with those of all others. The
/// frame is that of the first one; the others are moved, not turned.
class FloorAtlas {
 public:
  /// @param present keyframes of the present map, by `ids`  @param gap [m] from the walls of one map to those of the
  /// next
  FloorAtlas(const KeyframeGraph& present, std::span<const int> ids, const Floors& floors, double gap);

  /// Of all maps. They share their scans with those that they were made of.
  const KeyframeGraph& keyframes() const { return keyframes_; }

  struct Place {
    int floor = 0;       ///< 0: the present map; others from 1 on
    Pose2 T_floor_base;  ///< in that map's own frame
  };
  Place placeOf(const Pose2& T_atlas_base) const;

 private:
  /// Lays a map to the right of those that are there.
  void add(const KeyframeGraph& map, std::span<const int> ids);

  double gap_;
  KeyframeGraph keyframes_;
  struct Floor {
    double begin;            // [m] x from which on places are in it
    Eigen::Vector2d origin;  // [m] of its own frame
  };
  std::vector<Floor> floors_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();  // [m] right end and lower end of all that is there
};

}  // namespace slam
