// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tools/sim/depth/depth_wire.hpp"

namespace slam::sim {
namespace {

constexpr double kLongestDelay = 2000.0;  // [ms] of frames that are kept back

}  // namespace

bool DepthFaults::inject(std::string_view kind, double value) {
  const bool flag = value == 0.0 || value == 1.0;
  if (kind == "unplug" && flag) return unplugged_ = value != 0.0, true;
  if (kind == "freeze" && flag) return frozen_ = value != 0.0, true;
  if (kind == "garbage" && flag) return garbage_ = value != 0.0, true;
  if (kind == "stuck" && flag) {
    stuck_ = value != 0.0;
    picture_.clear();
    return true;
  }
  if (kind == "wrong" && value > 0.0 && value < 100.0) return wrong_ = value, true;
  if (kind == "slow" && value >= 1.0 && value <= 1000.0) return slow_ = static_cast<int>(value), true;
  if (kind == "delay" && value >= 0.0 && value <= kLongestDelay) return delay_ = fromSeconds(1e-3 * value), true;
  return false;
}

bool DepthFaults::spoil(std::span<std::uint8_t> frame) {
  if (frozen_ || frame.size() <= sizeof(DepthFrameHeader)) return false;
  if (++frames_ % slow_ != 0) return false;
  const std::span<std::uint8_t> pixels = frame.subspan(sizeof(DepthFrameHeader));
  if (stuck_) {
    if (picture_.size() != pixels.size()) picture_.assign(pixels.begin(), pixels.end());
    std::copy(picture_.begin(), picture_.end(), pixels.begin());
  }
  if (garbage_) {
    for (std::uint8_t& byte : pixels) byte = static_cast<std::uint8_t>(random_());
  }
  if (wrong_ != 1.0) {
    for (std::size_t i = 0; i + 1 < pixels.size(); i += 2) {
      std::uint16_t depth;
      std::memcpy(&depth, &pixels[i], sizeof depth);
      depth = static_cast<std::uint16_t>(std::min(65535.0, std::round(wrong_ * depth)));
      std::memcpy(&pixels[i], &depth, sizeof depth);
    }
  }
  return true;
}

}  // namespace slam::sim
