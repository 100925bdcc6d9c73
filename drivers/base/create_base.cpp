// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "drivers/base/base_protocols.hpp"
#include "firmware_if/create_oi.hpp"
#include "timing/stream_clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using create_oi::Mode;
using create_oi::Sensors;

constexpr Duration kGreeting = 500ms;  // between two, while no stream comes
constexpr Duration kSilent = 200ms;    // the stream comes every 15 ms
// From a zero to the first frame that was made behind it: a frame may wait for 15 ms in the robot, and as long again in
// an FTDI adapter.
constexpr Duration kObeyed = 40ms;

int millimetres(double speed) { return static_cast<int>(std::lround(1000.0 * speed)); }

class CreateProtocol : public BaseProtocol {
 public:
  void begin(Timestamp now) override {
    stream_.reset();
    clock_ = StreamClock();
    frame_ = now - kSilent;
    next_greeting_ = now;
    mode_ = Mode::kOff;
    left_safe_ = false;
  }

  Outgoing question(Timestamp now) override {
    if (now - frame_ < kSilent || now < next_greeting_) return {};
    next_greeting_ = now + kGreeting;
    Outgoing greeting = create_oi::start();
    greeting.add(create_oi::askForStream().bytes());
    return greeting;
  }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    stream_.push(byte, [&](std::span<const std::uint8_t> frame) {
      const auto sensors = create_oi::parseStream(frame);
      if (sensors) return handle(*sensors, now, take);
      ++other_;
    });
  }

  /// In passive mode no motor obeys; safe mode is entered for a command that turns one, and for nothing else.
  Outgoing speeds(const SideSpeeds& wanted, Timestamp now) override {
    if (!wanted.isZero() || !zero_sent_) zero_sent_ = wanted.isZero() ? std::optional(now) : std::nullopt;
    if (wanted.isZero() || obeys()) return create_oi::driveDirect(millimetres(wanted.left), millimetres(wanted.right));
    left_safe_ = false;
    return create_oi::enterSafe();
  }
  /// Passive mode again: it charges on its dock then, and its buttons work.
  Outgoing farewell() override {
    Outgoing bytes = create_oi::pauseStream();
    bytes.add(create_oi::start().bytes());
    return bytes;
  }
  std::uint32_t damage() const override { return stream_.damaged() + other_; }

 private:
  bool obeys() const { return mode_ == Mode::kSafe || mode_ == Mode::kFull; }

  void handle(const Sensors& sensors, Timestamp now, const Take& take) {
    frame_ = now;
    const bool obeyed = obeys();
    mode_ = sensors.mode;
    left_safe_ = !obeys() && (left_safe_ || obeyed);
    const bool has_zero = !obeys() || (sensors.requested[0] == 0 && sensors.requested[1] == 0);
    const bool lost = stream_.damaged() != std::exchange(damaged_, stream_.damaged());
    take({.stamp = clock_.stamp(now, lost),
          .counts = std::array<std::uint32_t, 2>{sensors.counts[0], sensors.counts[1]},
          .lifted = sensors.dropped,
          .bumped = sensors.bumped,
          .obeys = !left_safe_,
          .battery = static_cast<float>(1e-3 * sensors.voltage),
          .has_speed = zero_sent_ && now - *zero_sent_ >= kObeyed && has_zero});
  }

  create_oi::StreamDecoder stream_;
  StreamClock clock_;
  Timestamp frame_{}, next_greeting_{};
  Mode mode_ = Mode::kOff;
  bool left_safe_ = false;              // a wheel dropped, a cliff or the charger came, and no command since
  std::optional<Timestamp> zero_sent_;  // the first one behind another speed
  std::uint32_t other_ = 0, damaged_ = 0;
};

}  // namespace

std::unique_ptr<BaseProtocol> makeCreateProtocol(const BaseProtocolConfig&) {
  return std::make_unique<CreateProtocol>();
}

}  // namespace slam
