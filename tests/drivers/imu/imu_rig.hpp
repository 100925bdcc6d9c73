// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/imu/serial_imu.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/imu/emulated_imu.hpp"

namespace slam::test {

/// An IMU of the table with its driver, in virtual time.
class ImuRig {
 public:
  using Bytes = VirtualLine::Bytes;
  /// @param driver of the unit @param set the one that is configured @param baud [bit/s] that is configured; 0: none
  /// @param unit_baud [bit/s] of the unit; 0: the usual one
  explicit ImuRig(std::string_view driver, std::string_view set = {}, int baud = 0, int unit_baud = 0)
      : facts(*findImu(set.empty() ? driver : set)),
        emulator(sim::makeImu(driver)),
        unit_baud_(unit_baud > 0 ? unit_baud : findImu(driver)->bauds.front()),
        line(
            [this](std::span<const std::uint8_t> bytes) {
              written.insert(written.end(), bytes.begin(), bytes.end());
              if (!garbled && !noise) emulator->receive(bytes, pending_);
            },
            [this](Bytes& out) { pass(out); }),
        imu(
            {.facts = &facts, .port = "x", .baud = baud}, virtualNow,
            [this](const ImuSample& sample) { samples.push_back(sample); },
            [this](const std::string& path, int opened) {
              garbled = opened != unit_baud_;
              return line.opener()(path, opened);
            }) {}

  /// Ticks at 211 Hz until the condition holds. @return false: not within `patience`
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition, Duration patience = std::chrono::seconds(20)) {
    constexpr Duration kTick = std::chrono::nanoseconds(1'000'000'000 / 211);
    for (const Timestamp end = virtual_now + patience; !condition(); line.pass(kTick)) {
      if (virtual_now > end) return false;
      imu.tick();
    }
    return true;
  }
  void runFor(Duration time) {
    const Timestamp end = virtual_now + time;
    (void)runUntil([&] { return virtual_now >= end; }, 2 * time);
  }
  [[nodiscard]] bool connect() {
    return runUntil([this] { return state() == DeviceState::kStreaming; });
  }
  DeviceState state() { return imu.status().state.load(); }
  std::string words() { return imu.status().problem().words(); }
  bool has(const ProblemKind& kind) { return imu.status().problem().is(kind); }

  const ImuFacts& facts;
  std::unique_ptr<sim::EmulatedImu> emulator;
  /// [rad/s] about z, by the time since the rig's start.
  std::function<double(double)> rate = [](double) { return 0.0; };
  double since_start() const { return toSeconds(virtual_now - start_); }
  Timestamp start() const { return start_; }
  std::function<Duration()> delay;  ///< of a set of frames on its way
  double noise_sigma = 0.002;       ///< [rad/s], [m/s^2]
  bool garbled = false;             ///< the port was opened at a baud rate that is not the unit's
  bool noise = false;               ///< on the line, whatever the baud rate
  Bytes written;                    ///< by the driver
  std::vector<ImuSample> samples;

 private:
  /// A set is measured at each period; the mean rate since the one before is what a gyro's filter makes of it.
  void pass(Bytes& out) {
    for (; next_ <= virtual_now; next_ += sim::EmulatedImu::kPeriod) {
      const double t = toSeconds(next_ - start_);
      const auto dither = [this] { return noise_sigma * normal_(random_); };
      Bytes set;
      emulator->sample({dither(), dither(), rate(t) + dither()}, {dither(), dither(), 9.80665 + dither()}, set);
      late_.push_back({next_ + (delay ? delay() : Duration(0)), std::move(set)});
    }
    for (; !late_.empty() && late_.front().first <= virtual_now; late_.erase(late_.begin()))
      pending_.insert(pending_.end(), late_.front().second.begin(), late_.front().second.end());
    for (const std::uint8_t byte : std::exchange(pending_, {})) {
      if (!garbled && !noise) {
        out.push_back(byte);
      } else if (random_() % 2 == 0) {  // some of its bits make no byte
        out.push_back(static_cast<std::uint8_t>(random_()));
      }
    }
  }

  int unit_baud_;
  Timestamp start_ = virtual_now, next_ = virtual_now;
  std::vector<std::pair<Timestamp, Bytes>> late_;
  Bytes pending_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;

 public:
  VirtualLine line;
  SerialImu imu;  ///< ends first
};

}  // namespace slam::test
