// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/packet_lidar.hpp"
#include "drivers/lidar/serial_lidar.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"

namespace slam::test {

/// A lidar of the table and its driver, in virtual time.
class PacketRig {
 public:
  /// @param driver of the unit; @param set the one that is configured. @param baud [bit/s] that is configured; 0: right
  explicit PacketRig(std::string_view driver, std::string_view set = {}, int baud = 0)
      : emulator(lidarRoom, driver),
        facts(*findLidar(set.empty() ? driver : set)),
        line(
            [this](std::span<const std::uint8_t> bytes) {
              if (!garbled) emulator.receive(bytes, virtual_now, answers_);
            },
            [this](Bytes& out) {
              emulator.stream(virtual_now, answers_);
              for (const std::uint8_t byte : std::exchange(answers_, {})) {
                if (!garbled) {
                  out.push_back(byte);
                } else if (random_() % 2 == 0) {  // some of its bits make no byte
                  out.push_back(static_cast<std::uint8_t>(random_()));
                }
              }
            }),
        lidar(
            {.port = "x", .baud = baud > 0 ? baud : facts.baud, .line_device = facts.line_device},
            std::make_unique<PacketLidar>(facts, PacketLidarConfig{.baud = baud > 0 ? baud : facts.baud},
                                          test::virtualNow),
            test::virtualNow, [this](const LaserScan& scan) { scans.push_back(scan); },
            [this, right = findLidar(driver)->baud](const std::string& path, int opened) {
              garbled = opened != right;
              return line.opener()(path, opened);
            }) {}

  bool connect() { return lidar.connect(cancel); }
  /// @return false when the connection or the patience ended first
  bool collect(std::size_t count, Duration patience = std::chrono::seconds(20)) {
    const Timestamp deadline = virtual_now + patience;
    for (const std::size_t wanted = scans.size() + count; scans.size() < wanted;) {
      if (!lidar.poll(std::chrono::milliseconds(50)) || virtual_now > deadline) return false;
    }
    return true;
  }
  /// Polls until the connection is over. @return how long that took
  Duration pollUntilOver(Duration patience = std::chrono::seconds(20)) {
    const Timestamp begin = virtual_now;
    while (virtual_now < begin + patience && lidar.poll(std::chrono::milliseconds(50))) {
    }
    return virtual_now - begin;
  }
  std::string words() { return lidar.status().problem().words(); }
  DeviceState state() { return lidar.status().state.load(); }

  sim::PacketEmulator emulator;
  const LidarFacts& facts;
  bool garbled = false;  ///< the port was opened at a baud rate that is not the unit's
  std::atomic<bool> cancel{false};
  std::vector<LaserScan> scans;
  VirtualLine line;

 private:
  Bytes answers_;
  std::mt19937 random_{1};

 public:
  SerialLidar lidar;  ///< ends first: it stops the unit
};

}  // namespace slam::test
