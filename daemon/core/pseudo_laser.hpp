// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "core/pose2.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// What a depth image says about one bearing: three values, because no return is no free space.
struct PseudoBeam {
  enum class Kind : std::uint8_t {
    kUnknown = 0,  ///< nothing can be said
    kFree = 1,     ///< nothing stands between free_from and range; what lies behind is not known
    kHit = 2,      ///< the nearest obstacle stands at range, and nothing between free_from and it
  };
  Kind kind = Kind::kUnknown;
  float range = 0.0F;      ///< [m] along the floor, from the camera
  float free_from = 0.0F;  ///< [m] nearer than this nothing is known; at most range
};

/// A depth image projected to the nearest obstacle per bearing, in the camera's frame levelled to the floor (x forward,
/// y left). Fixed capacity, so that it crosses queues without allocation.
struct PseudoLaser {
  static constexpr int kCapacity = 1024, kSurfaceCapacity = 2048;

  /// Part of an obstacle behind the nearest one: a table top behind its edge, or behind a chair.
  struct Surface {
    std::uint16_t beam = 0;
    float from = 0.0F, to = 0.0F;  ///< [m] along the floor, from the camera
  };

  Timestamp stamp;            ///< of the depth image
  float bearing_min = 0.0F;   ///< [rad] of beam 0, counter-clockwise from x
  float bearing_step = 0.0F;  ///< [rad] from one beam to the next
  int size = 0;
  std::array<PseudoBeam, kCapacity> storage;
  int surface_count = 0;
  std::array<Surface, kSurfaceCapacity> surface_storage;

  std::span<const PseudoBeam> beams() const { return {storage.data(), static_cast<std::size_t>(size)}; }
  std::span<const Surface> surfaces() const {
    return {surface_storage.data(), static_cast<std::size_t>(surface_count)};
  }
  float bearing(int beam) const { return bearing_min + static_cast<float>(beam) * bearing_step; }
  /// @return false when there are too many; it is then not added
  bool push(const Surface& surface) {
    if (surface_count >= kSurfaceCapacity) return false;
    surface_storage[static_cast<std::size_t>(surface_count++)] = surface;
    return true;
  }
};

/// A pseudo-laser and the keyframe it was seen near.
struct DepthObservation {
  std::int32_t map_id = 0, session = 0;  ///< as of Keyframe
  std::int32_t keyframe = -1;            ///< id
  Pose2 T_keyframe_base;                 ///< at the image's stamp
  PseudoLaser laser;
};

}  // namespace slam
