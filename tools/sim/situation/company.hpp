// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <vector>

#include "core/pose2.hpp"
#include "tools/sim/situation/situation.hpp"
#include "tools/sim/world/solids.hpp"

namespace slam::sim {

/// What moves along with the robot, in the frame of its base.
class Company {
 public:
  explicit Company(const Situation& situation);

  /// The robot has come to this pose within dt [s].
  void step(const Pose2& T_world_base, double dt);

  /// @param bearing [rad] in the lidar's frame
  /// @return [m] from the lidar to what moves along; infinity where nothing does
  double range(const Pose2& T_base_lidar, double bearing) const;

  const Solids& solids() const { return solids_; }  ///< bodies of the robot apart

 private:
  struct Walker {
    Eigen::Vector2d place;  // [m] in base, which the walker keeps to ...
    Eigen::Vector2d at;     // ... and in world, where the walker is
    double heading = 0.0;   // [rad] in world
    double way = 0.0;       // [m] walked
  };

  void addLegs(const Pose2& T_base_person, double swing);
  void stepWalker(Walker& walker, double dt);

  Situation situation_;
  std::optional<Pose2> T_world_base_;
  std::vector<Walker> walkers_;
  double path_length_ = 0.0;  // [m] of the robot
  Eigen::Vector2d axle_;      // [m] of the cart, in world
  Solids solids_;
};

}  // namespace slam::sim
