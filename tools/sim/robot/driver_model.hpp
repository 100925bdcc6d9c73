// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "core/estimates.hpp"
#include "core/pose2.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim {

/// Drives the robot along a scene's route by its true pose: turn on the spot, drive straight, turn to the waypoint's
/// heading, pause; with bounded accelerations.
class DriverModel {
 public:
  explicit DriverModel(const Scene& scene) : scene_(scene), wait_(scene.settle) {}

  /// @param dt [s] since the last call
  /// @return twist that the robot shall have now
  Twist2 command(const Pose2& T_world_base, double dt);

  /// The robot has been put down at this waypoint of the route: after a pause it drives on to the next.
  void continueFrom(std::size_t waypoint);

  bool finished() const { return next_ >= scene_.route.size(); }
  /// Index of the measured waypoint at whose middle of the pause the last call stood, or -1.
  int reached() const { return reached_; }

 private:
  enum class Phase { kTurn, kDrive, kAlign, kPause };
  void beginPause(double seconds);
  double approach(double value, double target, double step) const;

  const Scene& scene_;
  std::size_t next_ = 0;
  Phase phase_ = Phase::kTurn;
  double wait_;            // [s] left before the drive, or of the present pause
  bool reported_ = false;  // the present pause
  int reached_ = -1;
  Twist2 twist_;
};

}  // namespace slam::sim
