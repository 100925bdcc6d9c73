// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tools/sim/depth/depth_wire.hpp"

namespace slam::sim {

bool DepthFaults::inject(std::string_view kind, double value) {
  using F = DepthFaults;
  static constexpr FaultKind<F> kKinds[] = {
      {"unplug", &F::unplugged_},          // the socket is gone; 0: it is back
      {"freeze", &F::frozen_},             // the connection stands, but no frame comes
      {"garbage", &F::garbage_},           // pixels of noise
      {"wrong", &F::wrong_, 0.01, 100.0},  // factor of all depths
      {"slow", &F::slow_, 1.0, 1000.0},    // only each n-th frame comes
      {"delay", &F::delay_, 0.0, 2000.0},  // [ms] that each frame comes later
      {"stuck", &F::stuck_},               // the same picture again and again, with new stamps
  };
  return injectFault(kKinds, *this, kind, value);
}

bool DepthFaults::spoil(std::span<std::uint8_t> frame) {
  if (frozen_ || frame.size() <= sizeof(DepthFrameHeader)) return false;
  if (++frames_ % slow_ != 0) return false;
  const std::span<std::uint8_t> pixels = frame.subspan(sizeof(DepthFrameHeader));
  if (!stuck_) picture_.clear();
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
