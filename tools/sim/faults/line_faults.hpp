// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <random>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// What may be wrong with a serial line, whatever device is at its end. Each lasts until it is set back.
///
/// | kind    | value                                                   | right |
/// |---------|---------------------------------------------------------|-------|
/// | unplug  | 1: the port is gone; 0: it is back                      | 0     |
/// | garbage | 1: each byte on its way to the host is a random one     | 0     |
/// | delay   | [ms] that each byte comes later                         | 0     |
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
