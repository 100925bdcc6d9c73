// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <fstream>
#include <span>

#include "core/pose2.hpp"
#include "graph/pose_graph.hpp"
#include "mapping/colour_image.hpp"

namespace slam {

/// What a frame shows beside the map.
struct ViewerScene {
  double log_s = 0.0;                          ///< [s] since the log's begin
  Pose2 T_map_base;                            ///< of the robot
  std::span<const Eigen::Vector2d> scan = {};  ///< [m] the present scan's points in base
  std::span<const Pose2> keyframes = {};       ///< T_map_base of each
  std::span<const Edge> edges = {};            ///< loop closures among them are drawn
};

constexpr Rgb kRobotColour{20, 150, 60}, kScanColour{220, 40, 40}, kClosureColour{245, 150, 0};

/// The map with the path of keyframes in blue, loop closures in orange, the scan in red and the robot in green, its
/// nose forward. The picture holds what is known of the map and the robot with a margin: it grows with the map. A cell
/// is up to eight pixels wide, as many as keep the longer side within 1400.
ColourImage drawScene(const MapImage& map, const ViewerScene& scene);

/// Numbered pictures of a run, DIR/frame-000000.png and so on, with a row for each in DIR/index.csv.
class ViewerFrames {
 public:
  /// Makes the folder; frames and index of an earlier run in it are replaced.
  /// @param period [s] of log time between frames; throws std::runtime_error when the folder cannot be written
  ViewerFrames(const std::filesystem::path& folder, double period);

  /// @return whether a frame is due at this second of the log
  bool due(double log_s) const { return log_s >= next_; }
  /// @throws std::runtime_error when it cannot be written
  void write(const MapImage& map, const ViewerScene& scene);
  /// @throws std::runtime_error when the index was not written whole
  void close();

 private:
  std::filesystem::path folder_;
  double period_, next_ = 0.0;
  int frames_ = 0;
  std::ofstream index_;
};

}  // namespace slam
