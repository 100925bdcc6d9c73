// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <utility>

#include "drivers/camera/usb_watch.hpp"

namespace slam::test {

/// A bus on which the camera is as the test says, and what a reset does, too.
struct FakeUsb : UsbWatch {
  bool on_bus = true, may_open = true, plugged_in = false;
  int resets = 0;
  std::function<void()> at_reset = [] {};
  bool present() override { return on_bus; }
  bool permitted() override { return may_open; }
  bool arrived() override { return std::exchange(plugged_in, false); }
  bool reset() override {
    ++resets;
    at_reset();
    return true;
  }
};

}  // namespace slam::test
