// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <random>
#include <vector>

#include "tools/sim/world/world.hpp"

namespace slam::sim {

/// Pieces of a world's walls that a lidar does not see as walls. Behind a window is nothing within reach; it sends a
/// beam back where that meets it squarely, and by its dirt now and then.
class Panes {
 public:
  struct Pane {
    Box box;
    bool mirror = false;
  };

  Panes(std::vector<Pane> panes, std::uint64_t seed);

  /// Makes panes, 1 to 2 m long, of walls drawn by the seed; none in a world without walls.
  static Panes drawn(const World& world, int glass, int mirrors, std::uint64_t seed);

  /// As World::castRay(), but infinity where nothing comes back.
  double castRay(const World& world, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double reach);

  const std::vector<Pane>& panes() const { return panes_; }

 private:
  std::vector<Pane> panes_;
  std::mt19937_64 random_;
};

}  // namespace slam::sim
