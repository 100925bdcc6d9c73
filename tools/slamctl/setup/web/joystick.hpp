// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "bus/udpm/lcm_link.hpp"
#include "tools/web/drive/drive_relay.hpp"

namespace slam {

/// Drives the slamd that records a calibration's drive, by the speeds of a page, with the stops of DriveRelay: its
/// thread sends the zero that is due, whatever the page, the network and the set-up do. Safe from several threads.
class Joystick {
 public:
  /// @param url of LCM @throws std::invalid_argument for one that is none
  explicit Joystick(const std::string& url);
  /// Stops what is driven.
  ~Joystick();
  Joystick(const Joystick&) = delete;
  Joystick& operator=(const Joystick&) = delete;

  /// As of DriveRelay.
  Problem take(const DriveRequest& request);
  /// Stops; no more is driven.
  void end();

 private:
  bool send(const Twist2& twist);
  void run();

  std::mutex linking_;
  LcmLink link_;
  DriveRelay relay_{[this](const Twist2& twist) { return send(twist); }};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace slam
