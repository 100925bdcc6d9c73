// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "core/timestamp.hpp"

namespace slam {

/// Ranges that count as returns.
struct RangeLimits {
  float min = 0.15F, max = 12.0F;  ///< [m]
  bool contains(float range) const { return range >= min && range <= max; }
};

/// One range sample of a lidar.
struct Beam {
  float range = 0.0F;        ///< [m]; 0: no return (which says nothing about the space along the beam)
  float bearing = 0.0F;      ///< [rad] in the lidar's frame, counter-clockwise from its x axis
  float time_offset = 0.0F;  ///< [s] from the scan's stamp to this sample
  float intensity = 0.0F;    ///< device units, larger is brighter; 0 where the device gives none
};

/// One turn of the lidar, beams in acquisition order. Fixed capacity, so that it crosses queues without allocation.
struct LaserScan {
  static constexpr int kCapacity = 4080;  ///< as many as one LCM datagram holds

  Timestamp stamp;          ///< the instant that Beam::time_offset counts from; drivers set it to the first beam
  float range_min = 0.15F;  ///< [m] shorter returns are not obstacles
  float range_max = 12.0F;  ///< [m] longer returns are not trusted
  int size = 0;
  // In a union, so that nobody clears 64 KB for the few beams that most scans have: those behind `size` are undefined.
  union {
    std::array<Beam, kCapacity> storage;
  };

  LaserScan() {}
  LaserScan(const LaserScan& other) { *this = other; }
  LaserScan& operator=(const LaserScan& other) {
    stamp = other.stamp;
    range_min = other.range_min;
    range_max = other.range_max;
    size = other.size;
    std::copy_n(other.storage.begin(), other.size, storage.begin());
    return *this;
  }

  std::span<const Beam> beams() const { return {storage.data(), static_cast<std::size_t>(size)}; }
  /// @return false when the scan is full; the beam is then not added
  bool push(const Beam& beam) {
    if (size >= kCapacity) return false;
    storage[static_cast<std::size_t>(size++)] = beam;
    return true;
  }
  bool isReturn(const Beam& beam) const { return beam.range >= range_min && beam.range <= range_max; }
};

/// Where the lidar sees the robot, or what the robot carries or tows.
struct BodyShape {
  std::array<std::uint16_t, 360> millimetres{};  ///< range by full degrees of a scan's bearings; 0: nothing there

  int degrees() const;    ///< that it takes of the turn
  double middle() const;  ///< [deg] of it, in (-180, 180]. @pre degrees() > 0
  /// Of a lidar whose bearings grow the other way.
  BodyShape mirrored() const;
  /// What of it is not in another one.
  BodyShape without(const BodyShape& other) const;
  /// Whether a point lies on it. @param p_lidar [m] @param margin [m] by which it may lie beside it
  bool holds(const Eigen::Vector2d& p_lidar, double margin) const;
  friend bool operator==(const BodyShape&, const BodyShape&) = default;
};

}  // namespace slam
