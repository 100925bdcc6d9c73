// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "core/timestamp.hpp"

namespace slam {

/// The floor as a camera with slightly wrong extrinsics sees it: height(x, y) = offset + slope_x x + slope_y y, in the
/// levelled camera's frame, x forward, y left, heights from where the floor should be.
struct FloorPlane {
  double offset = 0.0;                  ///< [m]
  double slope_x = 0.0, slope_y = 0.0;  ///< [1] radians, nearly

  double height(double x, double y) const { return offset + slope_x * x + slope_y * y; }
  double tilt() const { return std::hypot(slope_x, slope_y); }  ///< [rad], nearly
};

struct FloorTrackerConfig {
  double max_tilt = 0.052;   ///< [rad] the bracket and the suspension give no more (3 deg); followed up to here
  double max_offset = 0.04;  ///< [m] same of the height
  double gate = 0.03;        ///< [m] points further from the plane as known are no floor ...
  double gate_slope = 0.02;  ///< [1] ... and so much per metre of distance, for fast pitching; max_tilt at first
  double settle_time = 0.3;  ///< [s] in which the plane follows: a robot that brakes nods for longer
  int min_points = 60;       ///< fewer floor points say nothing
};

/// Follows the floor plane through the images of a depth camera, within bounds, and tells when the floor lies somewhere
/// else than it can: then the extrinsics are wrong.
///
/// After the first update no allocation. Not safe for concurrent use.
class FloorTracker {
 public:
  explicit FloorTracker(const FloorTrackerConfig& config) : config_(config) {}

  /// @param points points of one image, thinned out, in the levelled camera's frame, z up from where the floor should
  /// be
  /// @param camera_height [m] of the camera above the floor
  /// @return the tilt [rad] of the floor against where the extrinsics put it, when that or its height is beyond the
  /// bounds; the plane is then not changed
  std::optional<double> update(Timestamp stamp, const std::vector<Eigen::Vector3f>& points, double camera_height);

  const FloorPlane& plane() const { return plane_; }

 private:
  struct Fit {
    FloorPlane plane;
    int points = 0;
    double extent = 0.0;  ///< [m] standard deviation of the points ahead
  };
  Fit fitNear(const std::vector<Eigen::Vector3f>& points, const FloorPlane& guess) const;
  /// The plane that holds most of what the camera sees, if it may be the floor.
  struct Search {
    std::optional<double> tilt;  ///< [rad] it is not where the extrinsics put it
    bool level = false;          ///< it is
  };
  Search findElsewhere(const std::vector<Eigen::Vector3f>& points, double camera_height, int points_of_floor) const;

  FloorTrackerConfig config_;
  FloorPlane plane_;
  std::optional<Timestamp> last_;
};

}  // namespace slam
