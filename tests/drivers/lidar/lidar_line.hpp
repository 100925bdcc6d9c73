// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cmath>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/pose2.hpp"
#include "drivers/pseudo_terminal.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"

namespace slam::test {

/// An emulated lidar on a pseudo-terminal, in real time.
class LidarLine {
 private:
  template <typename Body>
  auto with(Body&& body) {
    const std::lock_guard lock(mutex_);
    return body();
  }

 public:
  explicit LidarLine(const sim::LidarIdentity& identity, sim::LidarEmulator::Measure measure = &LidarLine::room)
      : lidar_(std::move(measure), 5.5, identity), thread_([this] { run(); }) {}
  ~LidarLine() {
    quit_ = true;
    thread_.join();
  }

  const std::string& path() const { return line_.path(); }
  bool inject(std::string_view kind, double value) {
    return with([&] { return lidar_.inject(kind, value); });
  }
  std::uint16_t pwm() {
    return with([&] { return lidar_.pwm(); });
  }
  /// Turns each byte to the host into what a receiver at another baud rate makes of it.
  void garble() { garbled_ = true; }
  /// How often the host has sent this request byte behind A5.
  int count(rplidar::Request request) {
    return with([&] {
      int found = 0;
      for (std::size_t i = 1; i < heard_.size(); ++i) {
        found += heard_[i - 1] == 0xA5 && heard_[i] == static_cast<std::uint8_t>(request);
      }
      return found;
    });
  }

  /// 2 m ahead and 3 m behind.
  static double room(Timestamp, double bearing) { return std::abs(wrapAngle(bearing)) < 1.57 ? 2.0 : 3.0; }

 private:
  void run() {
    while (!quit_) {
      const Bytes in = line_.read(std::chrono::milliseconds(1));
      Bytes out;
      with([&] {
        heard_.insert(heard_.end(), in.begin(), in.end());
        const Timestamp now = monotonicNow();
        lidar_.receive(in, now, out);
        lidar_.stream(now, out);
        return true;
      });
      if (garbled_) {
        for (std::uint8_t& byte : out) byte = static_cast<std::uint8_t>(byte << 1 | 1);
      }
      if (!out.empty()) line_.write(out);
    }
  }

  PseudoTerminal line_;
  std::mutex mutex_;  // guards the next two
  sim::LidarEmulator lidar_;
  Bytes heard_;
  std::atomic<bool> quit_{false}, garbled_{false};
  std::thread thread_;
};

}  // namespace slam::test
