// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/device_time.hpp"

namespace slam {
namespace {

constexpr Duration kLongestGap = std::chrono::seconds(1);  // between two stamps; a step back is once around

}  // namespace

DeviceTime::Stamp DeviceTime::add(std::uint32_t ticks, Timestamp arrival) {
  const Duration passed = known_ ? tick_ * (ticks - last_) : Duration(0);
  const bool restarted = passed > kLongestGap;
  last_ = ticks;
  known_ = true;
  time_ += restarted ? -tick_ : passed;  // a time that goes back begins a DeviceClock anew
  return {clock_.stamp(time_, arrival), restarted};
}

}  // namespace slam
