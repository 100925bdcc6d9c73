// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "core/pose2.hpp"
#include "drivers/pseudo_terminal.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"

namespace slam::test {

/// 2 m ahead and 3 m behind.
inline double lidarRoom(Timestamp, double bearing) { return std::abs(wrapAngle(bearing)) < 1.57 ? 2.0 : 3.0; }

constexpr double kLidarTurns = 5.5;  // [1/s]

/// An emulated lidar on a pseudo-terminal, in real time.
class LidarLine {
 public:
  explicit LidarLine(const sim::LidarIdentity& identity)
      : lidar_(lidarRoom, kLidarTurns, identity), thread_([this] { run(); }) {}
  ~LidarLine() {
    quit_ = true;
    thread_.join();
  }

  const std::string& path() const { return line_.path(); }

 private:
  void run() {
    while (!quit_) {
      const Bytes in = line_.read(std::chrono::milliseconds(1));
      Bytes out;
      const Timestamp now = monotonicNow();
      lidar_.receive(in, now, out);
      lidar_.stream(now, out);
      if (!out.empty()) line_.send(out);
    }
  }

  PseudoTerminal line_;
  sim::LidarEmulator lidar_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

/// An emulated lidar in virtual time, whose faults a test chooses.
class VirtualLidar {
 public:
  explicit VirtualLidar(const sim::LidarIdentity& identity)
      : lidar_(lidarRoom, kLidarTurns, identity),
        line_(
            [this](std::span<const std::uint8_t> bytes) {
              heard_.insert(heard_.end(), bytes.begin(), bytes.end());
              lidar_.receive(bytes, virtual_now, answers_);
            },
            [this](Bytes& out) {
              lidar_.stream(virtual_now, answers_);
              for (const std::uint8_t byte : std::exchange(answers_, {})) {
                out.push_back(garbled_ ? static_cast<std::uint8_t>(byte << 1 | 1) : byte);
              }
            }) {}

  VirtualLine& line() { return line_; }
  bool inject(std::string_view kind, double value) { return lidar_.inject(kind, value); }
  std::uint16_t pwm() const { return lidar_.pwm(); }
  std::uint16_t speed() const { return lidar_.speed(); }
  /// Turns each byte to the host into what a receiver at another baud rate makes of it.
  void garble() { garbled_ = true; }
  /// How often the host has sent this request byte behind A5.
  int count(rplidar::Request request) const {
    int found = 0;
    for (std::size_t i = 1; i < heard_.size(); ++i) {
      found += heard_[i - 1] == 0xA5 && heard_[i] == static_cast<std::uint8_t>(request);
    }
    return found;
  }

 private:
  sim::LidarEmulator lidar_;
  Bytes heard_, answers_;
  bool garbled_ = false;
  VirtualLine line_;
};

}  // namespace slam::test
