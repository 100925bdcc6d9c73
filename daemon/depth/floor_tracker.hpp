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
  double max_tilt = 0.052;          ///< [rad] the bracket and the suspension give no more (3 deg); followed up to here
  double max_offset = 0.04;         ///< [m] same of the height
  double gate = 0.03;               ///< [m] points further from the plane as known are no floor ...
  double gate_slope = 0.02;         ///< [1] ... and so much per metre of distance, for fast pitching; max_tilt at first
  double settle_time = 0.3;         ///< [s] in which the plane follows: a robot that brakes nods for longer
  int min_points = 60;              ///< fewer floor points say nothing
  double final_gate = 0.015;        ///< [m] gate of the last iteration ...
  double final_gate_slope = 0.008;  ///< [1] ... and per metre of distance: a wall's foot is no floor
  double prior_offset = 0.02;       ///< [m] the plane stays where it is where an image does not tell ...
  double prior_slope = 0.02;        ///< [1] ... by a prior around the plane before ...
  double mount_offset = 0.015;  ///< [m] ... and one around the extrinsics: before a wall each image tells a little ...
  double mount_slope = 0.015;   ///< [1] ... its foot pulls, and the plane would creep away
  double point_sigma = 0.01;    ///< [m] of a floor point, all errors of one image together
  int independent = 30;         ///< so many points of an image are worth independent ones at most
  double narrow = 0.05;         ///< [m] standard deviation ahead: a strip so narrow may be a wall's foot
  int hypotheses = 200;         ///< planes tried elsewhere
  double level = 0.5;           ///< [1] of max_tilt: a plane that leans less is clearly level
  double max_lean = 0.45;       ///< [rad] a plane that leans more (26 deg) is no floor
  double nearest = 0.5;         ///< [1] times the camera's height: distance of what may be the floor, at least ...
  double farthest = 2.0;        ///< [1] ... and at most
  double thickness = 0.02;      ///< [m] of a plane ...
  double thickness_slope = 0.01;  ///< [1] ... and per metre of distance
  double scarce = 0.25;           ///< [1] share of all points: with fewer on the floor it may lie elsewhere
  double dominant = 0.25;         ///< [1] share of all points that a floor elsewhere must have

  void visitSettings(auto& v) {
    v.expert("max_tilt", max_tilt, "rad", 0.0, 0.3,
             "The camera's tilt follows the floor up to this angle from its mounting, as far as bracket and "
             "suspension give.");
  }
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
