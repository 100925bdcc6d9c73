// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// A scan handed to the map: deskewed returns and where they were taken. Fixed capacity, so that it crosses queues
/// without allocation.
struct Keyframe {
  struct Point {
    float x, y;  ///< [m] in base
  };

  std::int32_t map_id = 0;  ///< map that it belongs to
  std::int32_t id = 0;      ///< counts from 0 in its map; of a look: the keyframe nearest to it
  bool look = false;  ///< shows nothing new: it refreshes the grid and is then forgotten, so that a known place costs
                      ///< no memory however long the robot stays
  Timestamp stamp;
  Pose2 T_map_base;
  Pose2 T_base_lidar;
  int size = 0;
  std::array<Point, LaserScan::kCapacity> storage;

  std::span<const Point> points() const { return {storage.data(), static_cast<std::size_t>(size)}; }
};

}  // namespace slam
