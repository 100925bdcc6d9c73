// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/device_thread.hpp"

#include <poll.h>

#include "runtime/clock.hpp"

namespace slam {

void BackOff::wait(const std::function<bool()>& enough) {
  retry_.failed(monotonicNow());
  while (!retry_.due(monotonicNow()) && !enough()) ::poll(nullptr, 0, 20);
}

}  // namespace slam
