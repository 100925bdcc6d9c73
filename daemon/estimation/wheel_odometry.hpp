// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "estimation/base_kinematics.hpp"

namespace slam {

/// Geometry of a differential base.
struct DifferentialBase {
  double wheel_radius = 0.0325;  ///< [m]
  double half_track = 0.10075;   ///< [m] half the distance between the wheels' contact points

  void visitSettings(auto& v) {
    v.robot("wheel_radius", wheel_radius, "m", 0.005, 1.0, "A driven wheel has this radius.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("half_track", half_track, "m", 0.01, 2.0,
            "This is half the distance between the driven wheels; omni3: centre to wheel; mecanum4: half track "
            "plus half wheelbase.",
            "Measure it on each robot, or use slam-calibrate.");
  }
};

constexpr BaseKinematics kinematicsOf(const DifferentialBase& base) {
  return {BaseType::kDifferential, base.wheel_radius, base.half_track};
}

/// Dead reckoning of any wheeled base from its accumulated wheel angles.
///
/// Between two readings the base is taken to keep its twist, so that it runs on an arc: exact for constant wheel
/// speeds, sideways too. A missed reading therefore loses nothing.
class WheelOdometry {
 public:
  explicit WheelOdometry(const BaseKinematics& base) : base_(base) {}
  explicit WheelOdometry(const DifferentialBase& base) : WheelOdometry(kinematicsOf(base)) {}

  /// @param angles  accumulated angles [rad], order and sign as in BaseKinematics; four of a differential base are two
  ///                axles. A wrong number of them, or one that is not plausible, is as restart()
  /// @return        pose after this reading; the first reading is the origin
  const Pose2& add(std::span<const double> angles);
  /// The same for two wheels.
  const Pose2& add(double left, double right) { return add(std::array{left, right}); }

  /// The counters started again (e.g. the board was reset): the next reading continues from the present pose.
  void restart() { last_.reset(); }
  const Pose2& pose() const { return pose_; }
  /// [m] of the last step: see unexplained().
  double slip() const { return slip_; }

 private:
  struct Reading {
    WheelVector angles{};  // [rad]
    std::size_t count = 0;
  };
  BaseKinematics base_;
  std::optional<Reading> last_;
  Pose2 pose_;
  double slip_ = 0.0;  // [m]
};

}  // namespace slam
