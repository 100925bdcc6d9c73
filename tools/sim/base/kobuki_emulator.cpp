// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware_if/kobuki.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

constexpr Duration kFeedbackPeriod = std::chrono::milliseconds(20);

/// A Kobuki: it sends unasked as soon as it has power, and stops by itself 0.6 s after a base command.
class KobukiEmulator : public CountingBase {
 public:
  KobukiEmulator() : CountingBase(geometryOf("kobuki"), {65500, 40}) { use(); }  // both soon wrap

 protected:
  void restart() override {
    setCountsBack();
    frames_.reset();
    wanted_ = {};
    started_ = now();
    use();
  }
  void take(std::uint8_t byte, Bytes&) override {
    frames_.push(byte, [this](std::span<const std::uint8_t> frame) {
      const auto command = kobuki::parseCommand(frame);
      if (!command) return;
      const auto [speed, turn_rate] = kobuki::twistOf(*command);
      const double turn = kobuki::kHalfTrack * turn_rate;
      wanted_ = {speed - turn, speed + turn};
      commanded_ = now();
    });
  }
  void send(Bytes& out) override {
    constexpr double kCentidegree = 0.01 * std::numbers::pi / 180.0;
    constexpr std::int64_t kFirstStamp = 64500;  // [ms] so that it soon wraps
    if (started_ == Timestamp{}) started_ = now();
    for (next_ = std::max(next_, now() - kFeedbackPeriod); next_ <= now(); next_ += kFeedbackPeriod) {
      const auto all = counts();
      const std::int64_t stamp = kFirstStamp + (next_ - started_) / std::chrono::milliseconds(1);
      deliver(
          kobuki::encodeFeedback({.stamp = static_cast<std::uint16_t>(stamp),
                                  .bumped = bumped(),
                                  .dropped = lifted(),
                                  .counts = {static_cast<std::uint16_t>(all[0]), static_cast<std::uint16_t>(all[1])},
                                  .battery = 16.0,
                                  .turn_rate = static_cast<std::int16_t>(std::lround(turnRate() / kCentidegree))}),
          out);
    }
  }
  SideSpeeds sides() const override {
    return now() - commanded_ < fromSeconds(kobuki::kWatchdog) ? wanted_ : SideSpeeds{};
  }

 private:
  kobuki::Decoder frames_;
  SideSpeeds wanted_;
  Timestamp commanded_{}, started_{}, next_{};
};

}  // namespace

std::unique_ptr<EmulatedBase> makeKobuki() { return std::make_unique<KobukiEmulator>(); }

}  // namespace slam::sim
