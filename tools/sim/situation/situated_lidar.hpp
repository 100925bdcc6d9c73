// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <random>

#include "core/scan.hpp"
#include "tools/sim/situation/company.hpp"
#include "tools/sim/situation/panes.hpp"
#include "tools/sim/situation/situation.hpp"

namespace slam::sim {

/// A lidar, or two whose scans are merged, in a situation.
class SituatedLidar {
 public:
  SituatedLidar(const World& world, const Situation& situation, std::uint64_t seed);

  /// The company goes on with the robot.
  void step(const Pose2& T_world_base, double dt) { company_.step(T_world_base, dt); }

  struct Look {
    Beam beam;           ///< but its time
    bool world = false;  ///< it met the world rather than what moves along
  };
  /// Beam number `index` of a scan, clockwise. @param covered nothing comes back
  Look look(const Pose2& T_world_base, int index, bool covered);

  double bearing(int index) const;  ///< [rad] of that beam
  double trueRange(const Pose2& T_world_base, double bearing) const { return model_.trueRange(T_world_base, bearing); }
  double beamTime() const { return beam_time_; }  ///< [s] from beam to beam
  double gap() const { return gap_; }             ///< [s] from the last beam's time to the next turn
  float claimedRangeMax() const;

 private:
  double sight(const Pose2& T_world_base, const Pose2& T_base_lidar, double bearing, bool& world);

  const World& world_;
  Situation situation_;
  LidarModel model_;
  Company company_;
  Panes panes_;
  std::mt19937_64 random_;
  double beam_time_, gap_;
};

}  // namespace slam::sim
