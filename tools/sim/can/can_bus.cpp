// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/can/can_bus.hpp"

#include <cerrno>
#include <cstring>
#include <linux/can.h>
#include <stdexcept>

#include "drivers/can/can_socket.hpp"
#include "runtime/clock.hpp"

namespace slam::sim {
namespace {

namespace odrive = can::odrive;
constexpr Duration kOpenPeriod = std::chrono::milliseconds(100);  // between attempts

std::vector<std::uint32_t> commandIds(const std::array<int, 2>& nodes, can::Protocol protocol) {
  std::vector<std::uint32_t> ids;
  for (const int node : nodes) {
    if (protocol == can::Protocol::kVesc) {
      ids.push_back(can::vesc::idOf(node, can::vesc::Packet::kSetRpm) | CanPort::kExtended);
      continue;
    }
    for (const auto command : {odrive::Command::kInputVelocity, odrive::Command::kSetAxisState,
                               odrive::Command::kClearErrors, odrive::Command::kReadParameter})
      ids.push_back(odrive::idOf(node, command));
    ids.push_back(odrive::requestVersion(node).id | CAN_RTR_FLAG);
  }
  return ids;
}

}  // namespace

CanBus::CanBus(const std::string& interface, std::uint64_t seed, const std::array<int, 2>& nodes,
               can::Protocol protocol)
    : interface_(interface),
      ids_(commandIds(nodes, protocol)),
      port_(makeSocketCanPort(monotonicNow)),
      emulator_(seed, nodes, protocol) {
  int error = port_->open(interface, ids_);
  if (error == 0) error = port_->interfaceError();
  if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT)
    throw std::runtime_error("--can " + interface + ": this kernel has no CAN (modprobe can-raw vcan)");
  if (error == ENODEV)
    throw std::runtime_error("--can " + interface + ": no such interface (ip link add " + interface + " type vcan)");
  if (error == ENETDOWN)
    throw std::runtime_error("--can " + interface + ": the interface is down (ip link set " + interface + " up)");
  if (error != 0) throw std::runtime_error("--can " + interface + ": " + std::strerror(error));
}

void CanBus::step(Timestamp now, const CanReadings& readings) {
  StampedCanFrame received;
  while (port_->receive(received) == 0) emulator_.receive(received.frame);
  out_.clear();
  emulator_.step(now, readings, out_);
  bool gone = false;
  for (const can::Frame& frame : out_) {
    const int error = port_->send(frame);
    gone = gone || error == ENODEV || error == ENXIO || error == EBADF;
  }
  if (!gone || now < next_open_) return;
  next_open_ = now + kOpenPeriod;
  port_->open(interface_, ids_);
}

}  // namespace slam::sim
