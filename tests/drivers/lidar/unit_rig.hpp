// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/serial_lidar.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/lidar/emulated_lidar.hpp"

namespace slam::test {

/// Any emulated lidar and what drives it, in virtual time.
class UnitRig {
 public:
  UnitRig(std::unique_ptr<sim::EmulatedLidar> unit, std::unique_ptr<LidarUnit> driver, LineDevice line_device,
          const std::string& port = "/dev/lidar")
      : emulator(std::move(unit)),
        line([this](std::span<const std::uint8_t> bytes) { emulator->receive(bytes, virtual_now, answers_); },
             [this](Bytes& out) {
               emulator->stream(virtual_now, answers_);
               for (const std::uint8_t byte : std::exchange(answers_, {}))
                 out.push_back(garbled ? static_cast<std::uint8_t>(byte << 1 | 1) : byte);
             }),
        lidar(
            {.port = port, .line_device = line_device}, std::move(driver), test::virtualNow,
            [this](const LaserScan& scan) { scans.push_back(scan); }, line.opener()) {}

  bool connect() { return lidar.connect(cancel); }
  /// @return false when the connection or the patience ended first
  bool collect(std::size_t count, Duration patience = std::chrono::seconds(20)) {
    const Timestamp deadline = virtual_now + patience;
    for (const std::size_t wanted = scans.size() + count; scans.size() < wanted;) {
      if (!lidar.poll(std::chrono::milliseconds(50)) || virtual_now > deadline) return false;
    }
    return true;
  }
  bool stream(std::size_t count = 3) { return connect() && collect(count); }
  /// Polls until the connection is over. @return how long that took
  Duration pollUntilOver(Duration patience = std::chrono::seconds(20)) {
    const Timestamp begin = virtual_now;
    while (virtual_now < begin + patience && lidar.poll(std::chrono::milliseconds(50))) {
    }
    return virtual_now - begin;
  }
  std::string words() { return lidar.status().problem().words(); }
  DeviceState state() { return lidar.status().state.load(); }

  std::unique_ptr<sim::EmulatedLidar> emulator;
  bool garbled = false;  ///< the line damages each byte
  std::atomic<bool> cancel{false};
  std::vector<LaserScan> scans;
  VirtualLine line;

 private:
  Bytes answers_;

 public:
  SerialLidar lidar;  ///< ends first: it stops the unit
};

/// Beams that are not where the room of lidarRoom() is.
inline int wrongBeams(const LaserScan& scan) {
  int wrong = 0;
  for (const Beam& beam : scan.beams()) {
    const bool edge = std::abs(std::abs(beam.bearing) - 1.57) < 0.03;
    wrong += !edge && beam.range > 0.0F && std::abs(beam.range - lidarRoom({}, beam.bearing)) > 0.005;
  }
  return wrong;
}

}  // namespace slam::test
