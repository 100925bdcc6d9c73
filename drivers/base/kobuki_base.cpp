// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>

#include "drivers/base/base_protocols.hpp"
#include "firmware_if/kobuki.hpp"
#include "timing/device_clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using kobuki::Feedback;

constexpr int kZeros = 3;  // sent one behind the other to a base that is received: one of them has arrived
constexpr double kTurnRateUnit = 0.01 * std::numbers::pi / 180.0;  // [rad/s]

class KobukiProtocol : public BaseProtocol {
 public:
  void begin(Timestamp) override {
    frames_.reset();
    clock_ = DeviceClock();
    last_stamp_.reset();
    zeros_ = 0;
  }

  Outgoing question(Timestamp) override { return {}; }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    frames_.push(byte, [&](std::span<const std::uint8_t> frame) {
      const auto feedback = kobuki::parseFeedback(frame);
      if (feedback) handle(*feedback, now, take);
    });
  }

  Outgoing speeds(const SideSpeeds& wanted, Timestamp) override {
    zeros_ = wanted.isZero() ? zeros_ + 1 : 0;
    // The firmware makes wheel speeds of it by its own track.
    const double speed = 0.5 * (wanted.left + wanted.right);
    const double turn_rate = 0.5 * (wanted.right - wanted.left) / kobuki::kHalfTrack;
    return kobuki::encode(kobuki::commandOf(speed, turn_rate));
  }
  std::uint32_t damage() const override { return frames_.damaged(); }

 private:
  void handle(const Feedback& feedback, Timestamp now, const Take& take) {
    // The base's own time goes on with each stamp, by less than once around.
    if (last_stamp_) time_ += Duration(1ms) * static_cast<std::uint16_t>(feedback.stamp - *last_stamp_);
    last_stamp_ = feedback.stamp;
    BaseReading reading{.stamp = clock_.stamp(time_, now),
                        .counts = std::array<std::uint32_t, 2>{feedback.counts[0], feedback.counts[1]},
                        .lifted = feedback.dropped,
                        .bumped = feedback.bumped,
                        .battery = static_cast<float>(feedback.battery),
                        .has_speed = zeros_ >= kZeros};
    if (feedback.turn_rate) reading.turn_rate = kTurnRateUnit * *feedback.turn_rate;
    take(reading);
  }

  kobuki::Decoder frames_;
  DeviceClock clock_;
  Duration time_{0};  // of the base, since the first frame
  std::optional<std::uint16_t> last_stamp_;
  int zeros_ = 0;  // sent since the last other speed
};

}  // namespace

std::unique_ptr<BaseProtocol> makeKobukiProtocol(const BaseProtocolConfig&) {
  return std::make_unique<KobukiProtocol>();
}

}  // namespace slam
