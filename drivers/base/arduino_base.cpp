// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include "drivers/base/base_protocols.hpp"
#include "drivers/base/polled_protocol.hpp"
#include "firmware_if/arduino_bridge.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using arduino_bridge::Answer;

constexpr Duration kPeriod = 20ms;  // of asking for the counts: an answer takes up to 8 ms at 57600 bit/s
constexpr Duration kAwake = 300ms;  // a board that opening did not reset has answered by then

class ArduinoProtocol : public PolledProtocol {
 public:
  explicit ArduinoProtocol(const BaseProtocolConfig& config)
      : PolledProtocol(kPeriod),
        counts_per_metre_(config.counts_per_turn / (2.0 * std::numbers::pi * config.wheel_radius) / config.loop_rate) {}

  /// A board that opening has reset boots for 2 s, in which nothing is sent to its bootloader but what the first 0.3 s
  /// bring: one that was not reset, and may drive, gets its stop at once.
  void begin(Timestamp now) override {
    PolledProtocol::begin(now);
    opened_ = now;
    awake_ = false;
  }
  Outgoing question(Timestamp now) override {
    const Timestamp boots_from = opened_ + kAwake, boots_to = opened_ + fromSeconds(arduino_bridge::kBoot);
    if (!awake_ && now >= boots_from && now < boots_to) rest(boots_to);
    return PolledProtocol::question(now);
  }
  void push(std::uint8_t byte, Timestamp, const Take& take) override {
    const auto answer = lines_.push(byte);
    if (!answer) return;
    awake_ = true;
    switch (answer->kind) {
      case Answer::kNumber:
        if (settle(Request::kSync)) take({.stamp = taken()});
        return;
      case Answer::kCounts:
        if (settle(Request::kCounts))
          take({.stamp = taken(),
                .counts = std::array{static_cast<std::uint32_t>(answer->counts[0]),
                                     static_cast<std::uint32_t>(answer->counts[1])}});
        return;
      case Answer::kDone:
        if (settle(Request::kSpeeds)) take({.stamp = taken(), .has_speed = true});
        return;
      case Answer::kRefused:  // it is asked again when its time is up
        ++refused_;
    }
  }
  std::uint32_t damage() const override { return lines_.damaged() + refused_ + unanswered(); }

 protected:
  Outgoing encode(Request question) override {
    return question == Request::kSync ? arduino_bridge::askBaudRate() : arduino_bridge::askCounts();
  }
  Outgoing encodeSpeeds(const SideSpeeds& wanted) override {
    return arduino_bridge::encodeSpeeds(countsOf(wanted.left), countsOf(wanted.right));
  }
  void forget() override { lines_.reset(); }

 private:
  std::int32_t countsOf(double speed) const {
    constexpr double kMost = arduino_bridge::kMostCounts;
    return static_cast<std::int32_t>(std::lround(std::clamp(counts_per_metre_ * speed, -kMost, kMost)));
  }

  double counts_per_metre_;  // [1/m/Hz] counts per loop for 1 m/s
  arduino_bridge::LineDecoder lines_;
  Timestamp opened_{};
  bool awake_ = false;  // it has answered since the port was opened
  std::uint32_t refused_ = 0;
};

}  // namespace

std::unique_ptr<BaseProtocol> makeArduinoProtocol(const BaseProtocolConfig& config) {
  return std::make_unique<ArduinoProtocol>(config);
}

}  // namespace slam
