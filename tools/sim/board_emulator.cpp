// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/board_emulator.hpp"

#include <array>

namespace slam::sim {

using robolink::Command;

void BoardEmulator::renew(double left, double right, const robolink::Imu& imu, double uptime) {
  mileage_ = {static_cast<float>(-left), static_cast<float>(right), 0.0F, 0.0F};  // the left motor counts backwards
  imu_ = imu;
  imu_.online = 1;
  info_ = {static_cast<float>(uptime * 1e6), 41.0F, 23.0F, 11.8F, 80.0F};
}

void BoardEmulator::answer(Command command, std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& out) {
  std::array<std::uint8_t, robolink::kMaxFrame> frame;
  const std::size_t size = robolink::encodeFrame(robolink::kSlave, robolink::kMaster, command, payload, frame);
  out.insert(out.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size));
}

void BoardEmulator::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
  for (const std::uint8_t byte : bytes) {
    for (auto frame = decoder_.push(byte); frame; frame = decoder_.flush()) {
      const auto command = static_cast<Command>(frame->command);
      if (command == Command::kShakingHands) {
        greeted_ = true;  // stored, not acknowledged
      } else if (!greeted_) {
        answer(Command::kShakingHands, {}, out);
      } else if (command == Command::kGetMotorMileage) {
        answer(command, robolink::encodeMotorVector(mileage_), out);
      } else if (command == Command::kGetImu) {
        answer(command, robolink::encodeImu(imu_), out);
      } else if (command == Command::kGetSystemInfo) {
        answer(command, robolink::encodeSystemInfo(info_), out);
      }
    }
  }
}

}  // namespace slam::sim
