// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/base/serial_base.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/base/emulated_base.hpp"

namespace slam::test {

/// A base of the table with its driver, in virtual time; the robot drives as the base is told.
class BaseRig {
 public:
  using Bytes = VirtualLine::Bytes;
  /// @param driver of the base; @param set the one that is configured @param baud [bit/s] that is configured; 0: right
  explicit BaseRig(std::string_view driver, std::string_view set = {}, int baud = 0)
      : facts(*findBase(set.empty() ? driver : set)),
        geometry(sim::geometryOf(driver)),
        robot({}, 1, geometry.base),
        emulator(sim::makeBase(driver)),
        line(
            [this](std::span<const std::uint8_t> bytes) {
              written.insert(written.end(), bytes.begin(), bytes.end());
              if (!garbled && !noise) emulator->exchange(bytes, virtual_now, answers_);
            },
            [this](Bytes& out) {
              robot.step(emulator->drive(), toSeconds(virtual_now - std::exchange(stepped_, virtual_now)));
              emulator->renew(robot, virtual_now);
              emulator->exchange({}, virtual_now, answers_);
              if (delay > Duration(0)) {
                late_.push_back({virtual_now + delay, std::exchange(answers_, {})});
                for (; !late_.empty() && late_.front().first <= virtual_now; late_.erase(late_.begin()))
                  answers_.insert(answers_.end(), late_.front().second.begin(), late_.front().second.end());
              }
              for (const std::uint8_t byte : std::exchange(answers_, {})) {
                if (!garbled && !noise) {
                  out.push_back(byte);
                } else if (random_() % 2 == 0) {  // some of its bits make no byte
                  out.push_back(static_cast<std::uint8_t>(random_()));
                }
              }
            }) {
    baud_ = baud > 0 ? baud : facts.baud;
    right_ = findBase(driver)->baud;
    start();
  }

  void start(bool may_drive = true, SpeedLimits limits = {}) {
    base = std::make_unique<SerialBase>(
        SerialBaseConfig{.facts = &facts,
                         .port = "x",
                         .baud = baud_,
                         .robot = {.wheel_radius = geometry.base.wheel_radius,
                                   .half_track = geometry.base.half_track,
                                   .counts_per_turn = geometry.counts_per_turn,
                                   .loop_rate = 30.0,
                                   .may_drive = may_drive},
                         .gyro = facts.gyro,
                         .limits = limits},
        virtualNow,
        SerialBase::Sinks{.wheels = [this](const WheelAngles& angles) { wheels.push_back(angles); },
                          .imu = [this](const ImuSample& sample) { imu.push_back(sample); }},
        [this](const std::string& path, int opened) {
          garbled = opened != right_;
          return line.opener()(path, opened);
        });
  }
  /// As one that is killed: it says nothing at its end.
  void kill() {
    emulator->inject("deaf", 1.0);
    base.reset();
    emulator->inject("deaf", 0.0);
  }

  /// Ticks at 211 Hz until the condition holds, with `each` done before each tick. @return false: not within `patience`
  template <typename Condition, typename Each>
  [[nodiscard]] bool runUntil(Condition&& condition, Duration patience, Each&& each) {
    constexpr Duration kTick = std::chrono::nanoseconds(1'000'000'000 / 211);
    for (const Timestamp end = virtual_now + patience; !condition(); line.pass(kTick)) {
      if (virtual_now > end) return false;
      each();
      base->tick();
    }
    return true;
  }
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition, Duration patience = std::chrono::seconds(20)) {
    return runUntil(condition, patience, [] {});
  }
  void runFor(Duration time) {
    const Timestamp end = virtual_now + time;
    (void)runUntil([&] { return virtual_now >= end; }, 2 * time);
  }
  /// The same while a program sends that twist at each tick.
  void driveFor(Duration time, const Twist2& twist) {
    const Timestamp end = virtual_now + time;
    (void)runUntil([&] { return virtual_now >= end; }, 2 * time, [&] { base->command(twist, virtual_now); });
  }
  [[nodiscard]] bool connect() {
    return runUntil([this] { return state() == DeviceState::kStreaming; });
  }
  bool stands() const { return emulator->drive().vx == 0.0 && emulator->drive().omega == 0.0; }
  /// @return until the motors stand
  Duration timeToStop(Duration patience = std::chrono::seconds(5)) {
    const Timestamp begin = virtual_now;
    (void)runUntil([this] { return stands(); }, patience);
    return virtual_now - begin;
  }
  DeviceState state() { return base->wheelStatus().state.load(); }
  std::string words() { return base->wheelStatus().problem().words(); }
  bool has(const ProblemKind& kind) { return base->wheelStatus().problem().is(kind); }

  const BaseFacts& facts;
  sim::SimulatedGeometry geometry;
  sim::RobotModel robot;
  std::unique_ptr<sim::EmulatedBase> emulator;
  bool garbled = false;  ///< the port was opened at a baud rate that is not the base's
  bool noise = false;    ///< on the line, whatever the baud rate
  Duration delay{0};     ///< of all that the base sends
  Bytes written;         ///< by the driver
  std::vector<WheelAngles> wheels;
  std::vector<ImuSample> imu;
  VirtualLine line;

 private:
  int baud_ = 0, right_ = 0;
  Timestamp stepped_ = virtual_now;
  Bytes answers_;
  std::vector<std::pair<Timestamp, Bytes>> late_;
  std::mt19937 random_{1};

 public:
  std::unique_ptr<SerialBase> base;  ///< ends first: it stops the robot
};

}  // namespace slam::test
