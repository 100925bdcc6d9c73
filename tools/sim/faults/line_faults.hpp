// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <random>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {

/// What may be wrong with a serial line, whatever device is at its end. Each lasts until it is set back.
class LineFaults {
 public:
  /// @return false for a kind or a value that there is not
  bool inject(std::string_view kind, double value);

  bool unplugged() const { return unplugged_; }
  /// Bytes that a device sends at `now`. @return those that arrive at `now`
  std::vector<std::uint8_t> pass(std::vector<std::uint8_t> bytes, Timestamp now);

 private:
  bool unplugged_ = false, garbage_ = false;
  Duration delay_{0};
  struct Delayed {
    Timestamp due;
    std::vector<std::uint8_t> bytes;
  };
  std::deque<Delayed> delayed_;
  std::mt19937 random_{1};
};

}  // namespace slam::sim
