// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graph/keyframe_graph.hpp"
#include "mapping/edited_drawing.hpp"
#include "mapping/outline.hpp"
#include "problems/problem.hpp"

namespace slam {

/// What an edit of a map does.
enum class EditKind : std::uint8_t {
  kErase,  ///< the points inside leave the keyframes that there are; what is seen later is drawn again
  kFree,   ///< never drawn as occupied: glass, a curtain
  kWall,   ///< a line that nothing may pass; only in exports and for other programs, never used for matching
  kNoGo,   ///< a zone that the robot shall not enter; as kWall
  kRoom,   ///< a name for a zone, or for a spot
  kPlace   ///< a name for a pose
};
const char* nameOf(EditKind kind);
std::optional<EditKind> editKindOf(std::string_view name);

/// What an edit may be.
struct EditLimits {
  std::size_t corners = 1000;   ///< of an outline or line
  std::size_t name_bytes = 64;  ///< of a name, and of who made the edit
  std::size_t edits = 1000;     ///< of a map, in effect at a time: a site of a hundred rooms needs some hundreds
  std::size_t steps = 100;      ///< that can be undone
  double farthest = 100.0;      ///< [m] from the nearest keyframe, which the edit moves with: farther off, a turn of
                                ///< that keyframe by 0.1 deg shifts a corner by 0.2 m
  double depth_reach = 10.0;    ///< [m] of a depth camera
  double least_share = 0.3;     ///< [1] of the points around the robot that an erase leaves unless it is forced
  double around_robot = 12.0;   ///< [m] within which they are counted
  double widest_sigma = 100.0;  ///< [m, rad] of a place
};
inline constexpr EditLimits kEditLimits;

/// What a person asks for, in the map as it is at that moment.
struct EditRequest {
  EditKind kind = EditKind::kErase;
  std::string name, author;
  Outline points;                           ///< [m] in map: an outline, a line, or a spot
  double theta = 0.0;                       ///< [rad] of a place
  Eigen::Vector3d sigma = {0.0, 0.0, 0.0};  ///< [m, m, rad] of a place
  bool force = false;                       ///< also where the robot loses its reference
};

/// Why it cannot be an edit, whatever the map, with the fix; none: it can.
Problem problemWith(const EditRequest& request);

/// An edit as a map keeps it: it moves with the keyframes, as the map does.
struct MapEdit {
  struct Corner {
    int keyframe = 0;  ///< the nearest one when the edit was made
    Eigen::Vector2d p_keyframe = Eigen::Vector2d::Zero();
  };
  int id = 0;           ///< from 1 on, never used twice in a map
  bool active = false;  ///< neither undone nor removed
  EditKind kind = EditKind::kErase;
  std::string name, author;
  std::int64_t utime = 0;  ///< [us since the epoch] of making it
  std::vector<Corner> corners;
  double theta = 0.0;                               ///< [rad] of a place, in the keyframe of its corner
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< [m, m, rad] of a place, in map's axes when it was made
  Outline outline;                                  ///< [m] of an erase: in map as it was then ...
  std::map<int, Pose2> T_keyframe_map;              ///< ... and that map in each keyframe that it concerns
};

/// Ties a request to the keyframes of a map. @param in_map by keyframe: its place is known
/// @return nothing where the map has none, or all are too far from one of its points
std::optional<MapEdit> anchored(const EditRequest& request, const KeyframeGraph& keyframes,
                                std::span<const char> in_map);

/// [m] in map, as it is now; empty where a keyframe that it is tied to is no part of the map any more.
Outline pointsOf(const MapEdit& edit, const KeyframeGraph& keyframes, std::span<const char> in_map);
/// The pose of a place in map. @pre pointsOf() is not empty
Pose2 poseOf(const MapEdit& edit, const KeyframeGraph& keyframes);

}  // namespace slam
