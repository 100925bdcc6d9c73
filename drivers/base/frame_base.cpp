// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/base/base_protocols.hpp"
#include "drivers/base/device_time.hpp"
#include "firmware_if/slamd_base/base_frame.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using slamd_base::State;

constexpr double kMostSpeed = 2147483647.0;  // [counts/s] of a 32-bit number

class FrameProtocol : public BaseProtocol {
 public:
  explicit FrameProtocol(const BaseProtocolConfig& config)
      : counts_per_metre_(config.counts_per_turn / (2.0 * std::numbers::pi * config.wheel_radius)) {}

  void begin(Timestamp) override {
    receiver_.reset();
    time_ = DeviceTime(1us);
    received_ = sent_ = false;
  }
  Outgoing question(Timestamp) override { return {}; }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    receiver_.push(byte, [&](const std::uint8_t* frame) {
      State state;
      if (slamd_base::parseState(frame, &state)) return handle(state, now, take);
      ++other_;
    });
  }

  Outgoing speeds(const SideSpeeds& wanted, Timestamp) override {
    number_ = static_cast<std::uint8_t>(number_ % 255 + 1);
    sent_ = true;
    std::array<std::uint8_t, slamd_base::kLongestFrame> frame{};
    const std::size_t size =
        slamd_base::encodeSpeeds({number_, {countsOf(wanted.left), countsOf(wanted.right)}}, frame.data());
    Outgoing out;
    out.add({frame.data(), size});
    return out;
  }
  std::uint32_t damage() const override { return receiver_.damaged() + other_; }

 private:
  std::int32_t countsOf(double speed) const {
    return static_cast<std::int32_t>(std::lround(std::clamp(counts_per_metre_ * speed, -kMostSpeed, kMostSpeed)));
  }

  void handle(const State& state, Timestamp now, const Take& take) {
    // A number that the base has of a slamd before this one must not pass for this one's: it goes on from there.
    if (!std::exchange(received_, true)) {
      number_ = state.speeds;
      sent_ = false;
    }
    const DeviceTime::Stamp at = time_.add(state.stamp, now);
    BaseReading reading{
        .stamp = at.stamp,
        .restarted = at.restarted,
        .counts = std::array{static_cast<std::uint32_t>(state.counts[0]), static_cast<std::uint32_t>(state.counts[1])},
        .lifted = (state.flags & slamd_base::kLifted) != 0,
        .bumped = (state.flags & slamd_base::kBumped) != 0,
        .has_speed = sent_ && state.speeds == number_};
    if ((state.flags & slamd_base::kHasGyro) != 0) reading.turn_rate = 1e-6 * state.turn_rate;
    if (state.battery != 0) reading.battery = static_cast<float>(1e-3 * state.battery);
    take(reading);
  }

  double counts_per_metre_;
  slamd_base::Receiver receiver_;
  DeviceTime time_{1us};
  std::uint8_t number_ = 0;  // of the SPEEDS sent last
  bool received_ = false;    // a STATE, since the port was opened
  bool sent_ = false;        // SPEEDS, since then
  std::uint32_t other_ = 0;
};

}  // namespace

std::unique_ptr<BaseProtocol> makeFrameProtocol(const BaseProtocolConfig& config) {
  return std::make_unique<FrameProtocol>(config);
}

}  // namespace slam
