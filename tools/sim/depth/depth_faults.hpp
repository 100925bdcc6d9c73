// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// What may be wrong with the depth camera. Each lasts until it is set back.
///
/// | kind    | value                                                             | right |
/// |---------|-------------------------------------------------------------------|-------|
/// | unplug  | 1: the socket is gone; 0: it is back                              | 0     |
/// | freeze  | 1: the connection stands, but no frame comes                      | 0     |
/// | garbage | 1: pixels of noise                                                | 0     |
/// | stuck   | 1: the same picture again and again, with new stamps              | 0     |
/// | wrong   | factor of all depths                                              | 1     |
/// | slow    | only each n-th frame comes                                        | 1     |
/// | delay   | [ms] that each frame comes later                                  | 0     |
class DepthFaults {
 public:
  /// @return false for a kind or a value that there is not
  bool inject(std::string_view kind, double value);

  bool unplugged() const { return unplugged_; }
  Duration delay() const { return delay_; }
  /// Spoils a frame, header and pixels. @return false: it is not sent
  bool spoil(std::span<std::uint8_t> frame);

 private:
  bool unplugged_ = false, frozen_ = false, garbage_ = false, stuck_ = false;
  double wrong_ = 1.0;
  int slow_ = 1, frames_ = 0;
  Duration delay_{0};
  std::vector<std::uint8_t> picture_;  // shown for ever while stuck
  std::mt19937 random_{1};
};

}  // namespace slam::sim
