// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/timestamp.hpp"

namespace slam {

/// Pinhole model of a depth camera without distortion, in pixels; pixel (0, 0) is the upper left one, its centre is at
/// (0, 0).
struct DepthIntrinsics {
  int width = 0, height = 0;
  double fx = 0.0, fy = 0.0;  ///< focal lengths
  double cx = 0.0, cy = 0.0;  ///< principal point

  /// As OpenNI2 defines its world coordinates: by the fields of view alone, the principal point in the middle.
  /// @param horizontal, vertical fields of view [rad]
  static DepthIntrinsics fromFieldOfView(int width, int height, double horizontal, double vertical) {
    return {width,
            height,
            0.5 * width / std::tan(0.5 * horizontal),
            0.5 * height / std::tan(0.5 * vertical),
            0.5 * (width - 1),
            0.5 * (height - 1)};
  }
  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  friend bool operator==(const DepthIntrinsics&, const DepthIntrinsics&) = default;
};

/// One image of a depth camera.
struct DepthImage {
  Timestamp stamp;
  DepthIntrinsics intrinsics;
  /// [mm] along the camera's axis (not along the ray), row by row from the upper left, not mirrored: columns go to the
  /// right. 0: no data.
  std::vector<std::uint16_t> depth;
};

}  // namespace slam
