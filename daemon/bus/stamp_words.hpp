// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "core/timestamp.hpp"

namespace slam {

/// Words about the stamps of one sensor's samples, where they are too far from now for any use: of a log that is
/// played, or of a computer whose clock is wrong.
class StampWords {
 public:
  /// @param age of the newest sample; below zero: from the future
  /// @return lives as long as this; empty: the stamp is good
  const char* of(Duration age);

 private:
  Duration worded_{0};                         // age that the words are of: a sample's jitter does not change them
  std::map<std::int64_t, std::string> words_;  // by age [s] of three digits: readers may still have an old one
};

}  // namespace slam
