// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "firmware_if/robolink.hpp"

namespace slam::sim {

/// A HandsFree board at byte level: handshake after start, then answers with the values it renewed last.
class BoardEmulator {
 public:
  /// New values, as the board's own loop takes them at 50 Hz. @param left, right [rad] positive driving forward
  void renew(double left, double right, const robolink::Imu& imu, double uptime);
  /// Bytes from the host. @param out answers are appended
  void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out);

  bool greeted() const { return greeted_; }

 private:
  void answer(robolink::Command command, std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& out);

  robolink::Decoder decoder_{robolink::kSlave, robolink::kMaster};
  robolink::MotorVector mileage_{};
  robolink::Imu imu_;
  robolink::SystemInfo info_;
  bool greeted_ = false;
};

}  // namespace slam::sim
