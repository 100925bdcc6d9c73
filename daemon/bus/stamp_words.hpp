// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/timestamp.hpp"

namespace slam {

/// Words about the stamps of one sensor's samples, where they are not of our clock: of a log that is played, or of a
/// computer whose clock differs.
class StampWords {
 public:
  /// @param age of the newest sample; below zero: from the future @param differs the clocks do, by more than a delay
  /// @return lives as long as this; empty: the stamp is good
  const char* of(Duration age, bool differs = false);

 private:
  std::optional<Duration> worded_;             // age that the words are of: a sample's jitter does not change them
  std::map<std::int64_t, std::string> words_;  // by age [0.1 s] of three digits: readers may still have an old one
};

}  // namespace slam
