// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cerrno>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/can/can_port.hpp"

namespace slam::test {

/// What a fake port is plugged into; outlives it.
struct FakeCanBus {
  static constexpr Timestamp kStart{std::chrono::seconds(1000)};
  /// The clock of the driver under test.
  static inline Timestamp clock = kStart;
  static Timestamp now() { return clock; }

  FakeCanBus() { clock = kStart; }

  std::deque<StampedCanFrame> incoming;
  std::vector<can::Frame> sent;
  int open_error = 0, interface_error = 0, pending_error = 0, send_error = 0;  // errno
  int opens = 0, sends = 0;                                                    // attempts
  bool open = false;
  std::string interface;
  std::vector<std::uint32_t> ids;

  void put(const can::Frame& frame) { incoming.push_back({frame, clock}); }
  void putError(std::uint32_t classes, std::uint8_t controller = 0) {
    put({.id = classes, .size = 8, .error = true, .data = {0, controller}});
  }
};

/// SocketCAN's behaviour as far as drivers see it; filters by the ids asked for.
class FakeCanPort : public CanPort {
 public:
  explicit FakeCanPort(FakeCanBus& bus) : bus_(bus) { bus_.ids.reserve(32); }

  int open(const std::string& interface, std::span<const std::uint32_t> ids) override {
    close();
    ++bus_.opens;
    if (bus_.open_error != 0) return bus_.open_error;
    bus_.open = true;
    bus_.interface = interface;
    bus_.ids.assign(ids.begin(), ids.end());
    return 0;
  }
  void close() override { bus_.open = false; }
  int receive(StampedCanFrame& out) override {
    while (bus_.open && !bus_.incoming.empty()) {
      out = bus_.incoming.front();
      bus_.incoming.pop_front();
      const std::uint32_t id = out.frame.id | (out.frame.extended ? kExtended : 0);
      const bool wanted = std::find(bus_.ids.begin(), bus_.ids.end(), id) != bus_.ids.end();
      if (out.frame.error || (wanted && !out.frame.remote)) return 0;
    }
    return EAGAIN;
  }
  int send(const can::Frame& frame) override {
    ++bus_.sends;
    if (bus_.send_error == 0) bus_.sent.push_back(frame);
    return bus_.send_error;
  }
  int pendingError() override { return std::exchange(bus_.pending_error, 0); }
  int interfaceError() override { return bus_.interface_error; }

 private:
  FakeCanBus& bus_;
};

}  // namespace slam::test
