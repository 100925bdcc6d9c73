// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/can/can_port.hpp"
#include "tools/sim/can/can_emulator.hpp"

namespace slam::sim {

/// Puts an emulator's frames on a CAN interface of this machine, and gives it what the host sends.
class CanBus {
 public:
  /// @throws std::runtime_error, with the fix, when the kernel has no CAN or the interface is not there or down
  CanBus(const std::string& interface, std::uint64_t seed, const std::array<int, 2>& nodes = CanEmulator::kNodes,
         can::Protocol protocol = can::Protocol::kOdrive);

  /// To be called every few milliseconds. Frames that the interface does not take are lost, as on a real bus; one that
  /// was removed is used again when there is one of its name.
  void step(Timestamp now, const CanReadings& readings);
  CanEmulator& emulator() { return emulator_; }

 private:
  std::string interface_;
  std::vector<std::uint32_t> ids_;  // of what the host sends
  std::unique_ptr<CanPort> port_;
  Timestamp next_open_{};
  CanEmulator emulator_;
  std::vector<can::Frame> out_;
};

}  // namespace slam::sim
