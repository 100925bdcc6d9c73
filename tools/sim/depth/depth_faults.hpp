// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {

/// What may be wrong with the depth camera. Each lasts until it is set back.
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
