// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <net/if.h>
#include <thread>

#include "drivers/base/base_facts.hpp"
#include "drivers/can/can_axis.hpp"
#include "firmware_if/can_odrive.hpp"
#include "firmware_if/can_vesc.hpp"
#include "runtime/clock.hpp"
#include "tools/slamctl/doctor.hpp"
#include "tools/slamctl/drive_watchdogs.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

/// Whether both VESCs send the two frames that are needed of each.
Finding checkVescs(const CanConfig& can, CanPort& port, Duration patience) {
  namespace vesc = can::vesc;
  constexpr std::array kSides = {"left", "right"};
  const std::array<int, 2> nodes = {can.left_node, can.right_node};
  std::vector<std::uint32_t> ids;
  for (const int node : nodes) {
    for (const auto packet : {vesc::Packet::kStatus, vesc::Packet::kStatus5})
      ids.push_back(vesc::idOf(node, packet) | CanPort::kExtended);
  }
  if (const int error = port.open(can.interface, ids); error != 0)
    return {Finding::kWarning, "CAN: it cannot be listened to on " + can.interface + ": " + std::strerror(error),
            "sudo slamctl doctor"};
  std::array<bool, 2> speeds{}, positions{};
  receiveFor(patience, port, [&](const StampedCanFrame& received) {
    for (std::size_t side = 0; side < 2; ++side) {
      speeds[side] = speeds[side] || vesc::parseStatus(nodes[side], received.frame).has_value();
      positions[side] = positions[side] || vesc::parseStatus5(nodes[side], received.frame).has_value();
    }
  });
  port.close();
  for (std::size_t side = 0; side < 2; ++side) {
    if (speeds[side] && positions[side]) continue;
    const char* missing = speeds[side] ? "STATUS_5" : positions[side] ? "STATUS" : "frame";
    return {Finding::kFault,
            std::string("CAN: no ") + missing + " of the " + kSides[side] + " wheel's VESC (can." + kSides[side] +
                "_node = " + std::to_string(nodes[side]) + ")",
            "in VESC Tool: App Settings, General: CAN mode VESC, CAN status messages 1, 4 and 5 at 50 Hz, and the id; "
            "check the bit rate: ip -details link show " +
                can.interface};
  }
  return {Finding::kGood, "CAN: the VESCs of both wheels send STATUS and STATUS_5", ""};
}

}  // namespace

Finding checkCan(const std::string& interface, const std::filesystem::path& net) {
  const std::string up = "sudo ip link set " + interface + " up type can bitrate 500000 restart-ms 100";
  std::error_code error;
  if (!std::filesystem::exists(net / interface, error)) {
    return {Finding::kFault, "CAN: no interface " + interface,
            "plug the adapter in, then " + up + "; or set can.interface"};
  }
  unsigned flags = 0;
  std::ifstream(net / interface / "flags") >> std::hex >> flags;
  if ((flags & IFF_UP) == 0) return {Finding::kFault, "CAN: " + interface + " is down", up};
  int queue = 0;
  std::ifstream(net / interface / "tx_queue_len") >> queue;
  if (queue > 0 && queue < 128) {
    return {Finding::kWarning, "CAN: " + interface + " queues only " + std::to_string(queue) + " frames",
            "sudo ip link set " + interface + " txqueuelen 256"};
  }
  return {Finding::kGood, "CAN: " + interface + " is up", ""};
}

void receiveFor(Duration time, CanPort& port, const std::function<void(const StampedCanFrame&)>& take) {
  StampedCanFrame received;
  for (const Timestamp end = monotonicNow() + time; monotonicNow() < end;) {
    port.receive(received) == 0 ? take(received) : std::this_thread::sleep_for(1ms);
  }
}

FoundDrives listenForDrives(const std::string& interface, std::vector<int> first, CanPort& port, Duration patience) {
  namespace odrive = can::odrive;
  // Of all nodes there are more ids than a socket filters by: those that people use, and the first ones.
  for (int node = 0; first.size() < 32; ++node) {
    if (std::find(first.begin(), first.end(), node) == first.end()) first.push_back(node);
  }
  std::vector<std::uint32_t> ids;
  for (const int node : first) ids.push_back(odrive::idOf(node, odrive::Command::kHeartbeat));
  FoundDrives found{.error = port.open(interface, ids), .nodes = {}};
  if (found.error != 0) return found;
  receiveFor(patience, port, [&](const StampedCanFrame& received) {
    if (!received.frame.error) found.nodes.push_back(static_cast<int>(received.frame.id >> 5));
  });
  port.close();
  std::sort(found.nodes.begin(), found.nodes.end());
  found.nodes.erase(std::unique(found.nodes.begin(), found.nodes.end()), found.nodes.end());
  return found;
}

std::vector<int> listenForVescs(const std::string& interface, CanPort& port, Duration patience) {
  namespace vesc = can::vesc;
  constexpr int kAtOnce = 32;
  std::vector<int> found;
  for (int first = 0; first <= vesc::kMostId; first += kAtOnce) {
    std::vector<std::uint32_t> ids;
    for (int id = first; id < first + kAtOnce && id <= vesc::kMostId; ++id)
      ids.push_back(vesc::idOf(id, vesc::Packet::kStatus) | CanPort::kExtended);
    if (port.open(interface, ids) != 0) return {};
    receiveFor(patience, port, [&](const StampedCanFrame& received) {
      const auto id = static_cast<int>(received.frame.id & 0xFF);
      if (vesc::parseStatus(id, received.frame) && std::find(found.begin(), found.end(), id) == found.end())
        found.push_back(id);
    });
    port.close();
  }
  std::sort(found.begin(), found.end());
  return found;
}

Finding checkDrives(const CanConfig& can, CanPort& port, Duration patience) {
  if (can.protocol == can::Protocol::kVesc) return checkVescs(can, port, patience);
  const FoundDrives found = listenForDrives(can.interface, {can.left_node, can.right_node}, port, patience);
  if (found.error != 0)
    return {Finding::kWarning, "CAN: it cannot be listened to on " + can.interface + ": " + std::strerror(found.error),
            "sudo slamctl doctor"};
  const auto isOnBus = [&](int node) { return std::binary_search(found.nodes.begin(), found.nodes.end(), node); };
  std::string list;
  for (const int node : found.nodes) list += (list.empty() ? "" : ", ") + std::to_string(node);
  const bool both = isOnBus(can.left_node) && isOnBus(can.right_node);
  if (both) return {Finding::kGood, "CAN: the drives of both wheels send heartbeats", ""};
  const std::string missing = !isOnBus(can.left_node)
                                  ? "left wheel (can.left_node = " + std::to_string(can.left_node) + ")"
                                  : "right wheel (can.right_node = " + std::to_string(can.right_node) + ")";
  return {Finding::kFault, "CAN: no heartbeat of the " + missing,
          list.empty() ? "switch the drives on, check the bit rate: ip -details link show " + can.interface
                       : "nodes that send heartbeats: " + list + "; set can.left_node and can.right_node"};
}

std::optional<Finding> checkWatchdog(const BaseDeviceConfig& base, const CanConfig& can, CanPort& port) {
  if (!base.speed_commands) return std::nullopt;
  if (base.driver == BaseDriver::kHandsfree) {
    return Finding{Finding::kGood,
                   "drives: the board's own watchdog stops the motors 0.7 s after the last command; it is always on",
                   ""};
  }
  const bool on_can = base.driver == BaseDriver::kCan && can.protocol == can::Protocol::kVesc;
  if (on_can || base.driver == BaseDriver::kVesc)
    return Finding{
        Finding::kWarning,
        "drives: a VESC as delivered releases its motor 1 s after the last command; whether it does cannot be asked",
        "in VESC Tool: App Settings, General, Timeout: 500 ms, not 0"};
  if (const BaseFacts* facts = findBase(wordOf(base.driver))) {
    if (facts->stops_after > 0.0) {
      char after[32];
      std::snprintf(after, sizeof after, "%g s", facts->stops_after);
      return Finding{Finding::kGood,
                     std::string("drives: the base's own watchdog stops the motors ") + after +
                         " after the last command; it is always on",
                     ""};
    }
    return Finding{Finding::kWarning,
                   std::string("drives: ") + facts->name +
                       " has no watchdog that is always on: it may keep its last speed while slamd, the computer or "
                       "the cable is down",
                   facts->at_hand};
  }
  if (base.driver != BaseDriver::kCan) return std::nullopt;
  return checkDriveWatchdogs(can, port);
}

}  // namespace slam
