// SPDX-License-Identifier: BSD-3-Clause
#include "bus/stamp_words.hpp"

#include <algorithm>
#include <cmath>

#include "bus/freshness.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kOld = 5s;  // no sample that is on its way, and none that the filter has a use for
constexpr Duration kJitter = 1500ms;

}  // namespace

const char* StampWords::of(Duration age) {
  if (age < kOld && age >= -kFarAhead) return "";
  if (std::chrono::abs(age - worded_) > std::max<Duration>(kJitter, std::chrono::abs(age) / 100)) worded_ = age;
  std::int64_t seconds = std::llround(toSeconds(worded_)), digits = 1;
  while (std::abs(seconds) / digits >= 1000) digits *= 10;
  seconds = seconds / digits * digits;
  std::string text = "stamps are " + std::to_string(std::abs(seconds)) + " s ";
  text += seconds > 0 ? "old: use slam-replay for a log, else set the sender's clock"
                      : "ahead, the samples are not used: set the sender's clock";
  return words_.try_emplace(seconds, std::move(text)).first->second.c_str();
}

}  // namespace slam
