// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/drive_watchdogs.hpp"

#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "drivers/can/can_axis.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;

constexpr Duration kAnswer = 100ms;  // a drive answers within a millisecond, the bus is busy

enum class Watchdog : std::uint8_t { kUnknown, kOn, kOff };

constexpr const char* kFix =
    "in odrivetool, once: for both axes <axis>.config.watchdog_timeout = 0.5 and <axis>.config.enable_watchdog = True, "
    "then <odrive>.save_configuration()";

/// A drive, as far as its watchdog shows.
struct ObservedDrive {
  CanAxis axis;
  bool fed = false;           // a speed was sent to it meanwhile
  bool armed = true;          // whenever it told
  std::optional<bool> asked;  // its answer

  Watchdog watchdog() const {
    if (asked) return *asked ? Watchdog::kOn : Watchdog::kOff;
    if (!axis.lastHeartbeat()) return Watchdog::kUnknown;
    const std::uint32_t error = axis.lastHeartbeat()->axis_error;
    const bool tripped = axis.dialect() == odrive::Dialect::k05   ? (error & odrive::kWatchdogExpired05) != 0
                         : axis.dialect() == odrive::Dialect::k06 ? (error & odrive::kWatchdogExpired06) != 0
                                                                  : error == odrive::kWatchdogExpired06;
    if (tripped) return Watchdog::kOn;
    return !fed && armed && axis.obeys() ? Watchdog::kOff : Watchdog::kUnknown;
  }
};

class Listener {
 public:
  Listener(const CanConfig& can, CanPort& port) : nodes_{can.left_node, can.right_node}, port_(port) {}

  std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> ids;
    for (const int node : nodes_) {
      for (const auto command : {odrive::Command::kHeartbeat, odrive::Command::kVersion, odrive::Command::kParameter,
                                 odrive::Command::kInputVelocity})
        ids.push_back(odrive::idOf(node, command));
    }
    return ids;
  }
  void listenFor(Duration time) {
    receiveFor(time, port_, [this](const StampedCanFrame& received) {
      if (!received.frame.error) take(received);
    });
  }
  /// Firmware 0.6 alone answers.
  void ask(std::uint16_t endpoint) {
    endpoint_ = endpoint;
    for (const int node : nodes_) {
      port_.send(odrive::requestVersion(node));
      if (endpoint != 0) port_.send(odrive::requestParameter(node, endpoint));
    }
    listenFor(kAnswer);
  }
  const std::array<ObservedDrive, 2>& drives() const { return drives_; }

 private:
  void take(const StampedCanFrame& received) {
    for (std::size_t side = 0; side < 2; ++side) {
      const int node = nodes_[side];
      ObservedDrive& drive = drives_[side];
      if (odrive::parseInputVelocity(node, received.frame)) drive.fed = true;
      if (drive.axis.addHeartbeat(received.stamp, node, received.frame) && drive.axis.lastHeartbeat())
        drive.armed = drive.armed && drive.axis.obeys();
      if (const auto version = odrive::parseVersion(node, received.frame)) drive.axis.addVersion(*version);
      const auto parameter = odrive::parseParameter(node, received.frame);
      if (parameter && endpoint_ != 0 && parameter->endpoint == endpoint_ && parameter->value <= 1)
        drive.asked = parameter->value == 1;
    }
  }

  std::array<int, 2> nodes_;
  CanPort& port_;
  std::uint16_t endpoint_ = 0;
  std::array<ObservedDrive, 2> drives_;
};

/// Why it cannot be said, and how it can.
std::string howToKnow(const std::array<ObservedDrive, 2>& drives) {
  const auto is = [&](odrive::Dialect dialect) {
    return drives[0].axis.dialect() == dialect || drives[1].axis.dialect() == dialect;
  };
  std::string text;
  if (is(odrive::Dialect::k06))
    text =
        "set can.watchdog_endpoint to the id of axis0.config.enable_watchdog in the flat_endpoints.json of the drives' "
        "firmware, and run doctor again; or ";
  return text + "stop slamd, arm the drives and run doctor again: a drive that stays armed without frames has none";
}

}  // namespace

Finding checkDriveWatchdogs(const CanConfig& can, CanPort& port, Duration patience) {
  Listener listener(can, port);
  if (const int error = port.open(can.interface, listener.ids()); error != 0)
    return {Finding::kWarning,
            "drives: whether their watchdogs are on is not known, " + can.interface +
                " cannot be opened: " + std::strerror(error),
            "bring the interface up, and run doctor again"};
  listener.listenFor(patience);  // before anything is asked, which feeds a watchdog
  listener.ask(static_cast<std::uint16_t>(can.watchdog_endpoint));
  port.close();
  constexpr const char* kSides[] = {"left", "right"};
  const std::array<Watchdog, 2> found = {listener.drives()[0].watchdog(), listener.drives()[1].watchdog()};
  for (std::size_t side = 0; side < 2; ++side) {
    if (found[side] != Watchdog::kOff) continue;
    char time[32];
    std::snprintf(time, sizeof time, "%.1f s", toSeconds(patience));
    const std::string how =
        listener.drives()[side].asked ? "it says so" : std::string("it stayed armed for ") + time + " without a frame";
    return {Finding::kFault,
            std::string("drives: the watchdog of the ") + kSides[side] + " wheel's ODrive is off, or too slow: " + how +
                "; when slamd, the computer or the cable fails, the wheel turns on at its last speed for ever",
            kFix};
  }
  if (found[0] == Watchdog::kOn && found[1] == Watchdog::kOn)
    return {
        Finding::kGood,
        "drives: the ODrives' own watchdogs are on; they stop the wheels when slamd, the computer or the cable fails",
        ""};
  return {Finding::kWarning,
          "drives: whether the ODrives' own watchdogs are on cannot be seen now" +
              std::string(listener.drives()[0].axis.dialect() == odrive::Dialect::k05
                              ? ", and firmware 0.5 offers no way to ask over CAN"
                              : "") +
              "; they are off as delivered. slamd feeds them at 50 Hz, with zeros while nobody drives, and stops the "
              "wheels when it can reach them again; without a watchdog they turn on at the last speed while slamd, the "
              "computer or the cable fails",
          std::string(kFix) + "; to know: " + howToKnow(listener.drives())};
}

}  // namespace slam
