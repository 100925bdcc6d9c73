// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "core/pose2.hpp"

namespace slam {

/// Geometry of a differential base.
struct DifferentialBase {
  double wheel_radius = 0.0325;  ///< [m]
  double half_track = 0.10075;   ///< [m] half the distance between the wheels' contact points
};

/// Dead reckoning of a differential base from its accumulated wheel angles.
///
/// Between two readings the base is taken to run on an arc, which is exact for constant wheel speeds; a missed reading
/// therefore loses nothing.
class WheelOdometry {
 public:
  explicit WheelOdometry(const DifferentialBase& base) : base_(base) {}

  /// @param left, right  accumulated angles [rad], positive when the base drives forward
  /// @return             pose after this reading; the first reading is the origin
  const Pose2& add(double left, double right);

  /// The counters started again (e.g. the board was reset): the next reading continues from the present pose.
  void restart() { last_.reset(); }
  const Pose2& pose() const { return pose_; }

 private:
  struct Angles {
    double left, right;  // [rad]
  };
  DifferentialBase base_;
  std::optional<Angles> last_;
  Pose2 pose_;
};

}  // namespace slam
