// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <type_traits>

// What goes over the stream socket DIR/depth between slam-sim and a camera driver, in the host's byte order: the driver
// asks once for a mode, then frames come, each a header and the pixels, 16 bits each, row by row from the upper left.
namespace slam::sim {

struct DepthModeRequest {
  static constexpr std::uint32_t kMagic = 0x4D4C5344;  // "DSLM"
  std::uint32_t magic = kMagic;
  std::uint32_t width = 0, height = 0;  ///< [px]
  std::uint32_t rate = 0;               ///< [Hz]
};

struct DepthFrameHeader {
  static constexpr std::uint32_t kMagic = 0x464C5344;  // "DSLF"
  std::uint32_t magic = kMagic;
  std::uint32_t width = 0, height = 0;               ///< [px]
  std::uint32_t frame = 0;                           ///< index, from 1; a gap is a lost frame
  std::uint64_t time = 0;                            ///< [us] on the camera's clock, which began with the stream
  std::uint32_t size = 0;                            ///< [bytes] of the pixels
  float horizontal_fov = 0.0F, vertical_fov = 0.0F;  ///< [rad]
  std::uint32_t reserved = 0;                        ///< 0
};

static_assert(std::is_trivially_copyable_v<DepthModeRequest> && sizeof(DepthModeRequest) == 16);
static_assert(std::is_trivially_copyable_v<DepthFrameHeader> && sizeof(DepthFrameHeader) == 40);

inline constexpr float kDepthHorizontalFov = 1.0226F, kDepthVerticalFov = 0.7966F;  ///< [rad]

/// What the camera can be set to.
struct DepthMode {
  int width, height;  ///< [px]
  int rate;           ///< [Hz]
};
inline constexpr DepthMode kDepthModes[] = {{320, 240, 30}, {320, 240, 60}, {640, 480, 30}};

constexpr bool isDepthMode(std::uint32_t width, std::uint32_t height, std::uint32_t rate) {
  for (const DepthMode& mode : kDepthModes) {
    if (static_cast<int>(width) == mode.width && static_cast<int>(height) == mode.height &&
        static_cast<int>(rate) == mode.rate) {
      return true;
    }
  }
  return false;
}

}  // namespace slam::sim
