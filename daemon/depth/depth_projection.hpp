// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/depth_image.hpp"
#include "core/pseudo_laser.hpp"
#include "depth/depth_rays.hpp"
#include "depth/floor_tracker.hpp"
#include "depth/visible_ranges.hpp"

namespace slam {

struct DepthProjectionConfig {
  DepthExtrinsics extrinsics;
  double floor_clearance = 0.05;  ///< [m] what is lower is driven over
  double robot_height = 0.80;     ///< [m] what begins higher is driven under
  double range_min = 0.5;         ///< [m] depth below is not trusted: the camera's blind zone
  double range_max = 4.0;         ///< [m] obstacles beyond are not reported; quantisation alone is 5 cm there
  double bearing_step = 0.0087;   ///< [rad] of the beams; half a degree is 3.5 cm at range_max
  int median = 1;                 ///< images whose pixel-wise median is projected: 1 (none) or 3
  FloorTrackerConfig floor = {};
  double slot = 0.05;                           ///< [m] of range, in which points are counted together
  double points_per_pixel = 8.0 / (640 * 480);  ///< of an obstacle: fewer are flying pixels ...
  int fewest_points = 3;                        ///< ... and no fewer than this
  double depth_sigma = 2.9e-3;                  ///< [1/m] times depth squared: a step of the depth's quantisation
  int peak = 4;                ///< a slot with so many times the points is the wall, the other its noise
  double fewest_valid = 0.02;  ///< [1] share of all pixels with depth
  double most_below = 0.15;    ///< [1] share of the floor's points that lie below it: no stairs are so wide
  double below = 0.10;         ///< [m] under the floor

  void visitSettings(auto& v) {
    v.site("floor_clearance", floor_clearance, "m", 0.01, 0.5, "The robot drives over things that are lower than this.",
           "Set it to the height of the step that the wheels can take.");
    v.site("robot_height", robot_height, "m", 0.05, 3.0, "The robot drives under things that begin above this height.",
           "Set it to the height of the robot with its load.");
    v.expert("range_min", range_min, "m", 0.1, 5.0, "Depth values that are nearer than this are ignored.");
    v.expert("range_max", range_max, "m", 0.5, 10.0,
             "The camera draws obstacles up to this distance; its depth has steps of 5 cm at 4 m, and the lidar "
             "sees farther.");
    v.expert(
        "median", median, "", 1, 3,
        "Each pixel is the median of this many images: 1 for none, or 3 for less noise on a robot that moves slowly.");
    floor.visitSettings(v);
  }
};

enum class DepthStatus : std::uint8_t {
  kOk,
  kWrongSize,   ///< pixels and intrinsics do not agree
  kNoDepth,     ///< hardly any pixel holds a depth: covered, blinded or broken
  kTilted,      ///< the floor is not where the extrinsics put it
  kBelowFloor,  ///< much of the image lies below the floor
};

/// Projects depth images to the nearest obstacle per bearing. [Paper] "Indoor Robot SLAM with Multi-Sensor Fusion",
/// section III.B (pseudo two-dimensional laser data), with free space claimed only where it was seen: a beam is free
/// where all heights from the floor to the robot's top were looked through.
///
/// The small tilt of bracket and suspension is estimated from the floor itself. No thread, clock or I/O; after the
/// first image of a size no allocation. Not safe for concurrent use.
class DepthProjection {
 public:
  /// @throws std::invalid_argument where the configuration has no camera height or no beams
  explicit DepthProjection(const DepthProjectionConfig& config);

  using Status = DepthStatus;
  /// @return kOk and the beams in laser(), or why the image is of no use
  Status project(const DepthImage& image);

  const PseudoLaser& laser() const { return laser_; }
  const FloorPlane& floor() const { return floor_.plane(); }
  /// [rad] of the floor against the extrinsics when the last image was kTilted
  double tilt() const { return tilt_; }

 private:
  struct Slot {
    int points = 0;
    float sum = 0.0F;  // [m] of ranges
  };
  void prepare(const DepthIntrinsics& intrinsics);
  const std::vector<std::uint16_t>& smoothed(const std::vector<std::uint16_t>& depth);
  Status trackFloor(const DepthImage& image, const std::vector<std::uint16_t>& depth);
  struct DepthInterval {
    std::uint16_t from = UINT16_MAX, to = UINT16_MAX;  // [mm]; by default no pixel's
  };
  DepthInterval obstaclesOf(const DepthRays::Row& row, float lift_low, float lift_high) const;
  void sortPixels(const std::vector<std::uint16_t>& depth);
  int firstObstacle(int beam) const;
  float rangeAround(int beam, int slot) const;
  VisibleRanges sightOf(int beam) const;
  void addSurfaces(int beam, int hit_slot);
  bool isSurface(int beam, int slot) const;

  DepthProjectionConfig config_;
  FloorTracker floor_;
  DepthRays rays_;
  int slots_, min_points_ = 1;
  std::vector<Slot> slot_of_;         // obstacle points by beam and range
  std::vector<int> valid_;            // pixels with depth, by beam and band
  std::vector<float> lift_;           // [1] by beam: height per distance that the floor's tilt adds
  std::vector<std::uint16_t> kinds_;  // of a row's pixels
  std::vector<Eigen::Vector3f> points_;
  std::vector<std::uint16_t> older_, oldest_, median_;
  PseudoLaser laser_;
  double tilt_ = 0.0;
};

}  // namespace slam
