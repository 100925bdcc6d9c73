// SPDX-License-Identifier: BSD-3-Clause
#include "bus/stamp_words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bus/freshness.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kOld = 5s;  // no sample that is on its way, and none that the filter has a use for
constexpr Duration kJitter = 1500ms, kLittleJitter = 500ms;  // of the age of old samples, and of others

}  // namespace

const char* StampWords::of(Duration age, bool differs) {
  if (!differs && age < kOld && age >= -kFarAhead) return worded_.reset(), "";
  const Duration size = std::chrono::abs(age);
  const Duration jitter = size < kOld ? kLittleJitter : std::max<Duration>(kJitter, size / 100);
  if (!worded_ || std::chrono::abs(age - *worded_) > jitter) worded_ = age;
  std::int64_t tenths = std::llround(10.0 * toSeconds(*worded_)), digits = std::abs(tenths) < 100 ? 1 : 10;
  while (std::abs(tenths) / digits >= 1000) digits *= 10;
  tenths = tenths / digits * digits;
  char number[32];
  std::snprintf(number, sizeof number, digits == 1 ? "%.1f" : "%.0f", 0.1 * static_cast<double>(std::abs(tenths)));
  std::string text = std::string("stamps are ") + number;
  text += tenths > 0 ? " s old: use slam-replay for a log; else the clocks differ, slamd goes by the difference"
                     : " s ahead: the clocks differ, slamd goes by the difference";
  text += "; set the sender's clock: timedatectl set-ntp true";
  return words_.try_emplace(tenths, std::move(text)).first->second.c_str();
}

}  // namespace slam
