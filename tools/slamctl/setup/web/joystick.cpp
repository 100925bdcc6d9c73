// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/web/joystick.hpp"

#include <poll.h>

#include "runtime/clock.hpp"
#include "tools/web/drive/drive_sender.hpp"

namespace slam {

Joystick::Joystick(const std::string& url) : link_(url) {
  link_.tend(monotonicNow());
  thread_ = std::thread([this] { run(); });
}

Joystick::~Joystick() {
  end();
  ends_ = true;
  thread_.join();
}

Problem Joystick::take(const DriveRequest& request) { return relay_.take(request, monotonicNow()); }

void Joystick::end() { relay_.end(monotonicNow()); }

bool Joystick::send(const Twist2& twist) {
  const std::lock_guard lock(linking_);
  return publishDrive(link_, twist, monotonicNow());
}

void Joystick::run() {
  constexpr int kTurn = 10;  // [ms] of the loop: a zero is late by no more
  while (!ends_) {
    pollfd waiting{-1, POLLIN, 0};
    {
      const std::lock_guard lock(linking_);
      link_.receive();
      link_.tend(monotonicNow());
      waiting.fd = link_.descriptor();
    }
    relay_.tend(monotonicNow());
    ::poll(&waiting, 1, kTurn);
  }
}

}  // namespace slam
