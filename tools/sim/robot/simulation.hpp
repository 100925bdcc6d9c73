// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/pose_history.hpp"
#include "tools/sim/robot/driver_model.hpp"
#include "tools/sim/robot/robot_model.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim {

/// True pose at a waypoint where accuracy is reported.
struct WaypointVisit {
  Timestamp stamp;
  int waypoint = 0;  ///< index in the scene's route
  Pose2 pose;
};

/// The robot on its way through a scene, in steps of kStep; time begins where the caller says.
class Simulation {
 public:
  static constexpr Duration kStep = std::chrono::milliseconds(5);

  Simulation(const Scene& scene, std::uint64_t seed, Timestamp start, const RobotErrors& errors = {},
             const DifferentialBase& nominal = kNominalBase);

  void step();
  /// The robot stands until this is called.
  void release() { released_ = true; }

  /// From now on it drives as its base is told, not along the route; its motors stall where something is in the way.
  void obey(const Twist2& twist) { told_ = twist; }

  /// Someone takes the robot to a waypoint of the route, with that heading [rad], and leaves it to drive on from there.
  void carryTo(std::size_t waypoint, double heading, double seconds);
  bool carried() const { return carrying_.has_value(); }

  Timestamp now() const { return now_; }
  /// Time since the release [s], 0 before: the time that the world's moving things go by.
  double driveTime() const { return toSeconds(driven_ * kStep); }
  bool finished() const { return driver_.finished(); }
  RobotModel& robot() { return robot_; }
  const PoseHistory& history() const { return history_; }  ///< true poses of the last seconds
  const std::vector<WaypointVisit>& visits() const { return visits_; }

 private:
  struct Carrying {
    Pose2 from, to;
    std::size_t waypoint;
    double seconds, done;
  };
  void carry(double dt);
  /// @return the twist that its base is told, without what would drive it into something
  Twist2 unobstructed() const;

  const Scene& scene_;
  DriverModel driver_;
  RobotModel robot_;
  PoseHistory history_{2000};
  std::vector<WaypointVisit> visits_;
  Timestamp now_;
  bool released_ = false;
  std::optional<Carrying> carrying_;
  std::optional<Twist2> told_;  // none: it drives along the route
  std::int64_t driven_ = 0;     // steps since the release
};

}  // namespace slam::sim
