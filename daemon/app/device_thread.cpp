// SPDX-License-Identifier: BSD-3-Clause
#include "app/device_thread.hpp"

#include <algorithm>
#include <poll.h>

#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kFirstBackOff = 100ms, kLongestBackOff = 1s;

}  // namespace

void BackOff::wait(const std::function<bool()>& enough) {
  wait_ = std::clamp(2 * wait_, kFirstBackOff, kLongestBackOff);
  for (const Timestamp end = monotonicNow() + wait_; monotonicNow() < end && !enough();) ::poll(nullptr, 0, 20);
}

}  // namespace slam
