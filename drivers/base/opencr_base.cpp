// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/base_protocols.hpp"
#include "drivers/base/device_time.hpp"
#include "drivers/base/polled_protocol.hpp"
#include "firmware_if/opencr.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using opencr::Packet;

constexpr Duration kOpencrPeriod = 20ms;  // of reading the table, which the board renews about as often
constexpr Duration kBeating = 100ms;      // of the heartbeats, a fifth of what the board waits for one

class OpencrProtocol : public PolledProtocol {
 public:
  explicit OpencrProtocol(const BaseProtocolConfig& config)
      : PolledProtocol(kOpencrPeriod), half_track_(config.half_track) {}

  void begin(Timestamp now) override {
    PolledProtocol::begin(now);
    next_beat_ = now;
    time_ = DeviceTime(1ms);
  }
  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    frames_.push(byte, [&](std::span<const std::uint8_t> frame) {
      if (const auto packet = opencr::parse(frame)) handle(*packet, now, take);
    });
  }
  std::uint32_t damage() const override { return frames_.damaged() + unanswered(); }

 protected:
  Outgoing encode(Request question) override {
    return question == Request::kSync ? opencr::ping() : opencr::readTable();
  }
  Outgoing encodeSpeeds(const SideSpeeds& wanted) override {
    // The firmware makes wheel speeds of it by its own track.
    return opencr::encodeSpeeds(0.5 * (wanted.left + wanted.right), 0.5 * (wanted.right - wanted.left) / half_track_);
  }
  Outgoing encodeOther(Timestamp now) override {
    if (now < next_beat_) return {};
    next_beat_ = now + kBeating;
    return opencr::beat(++heartbeat_);
  }
  void forget() override { frames_.reset(); }

 private:
  void handle(const Packet& packet, Timestamp now, const Take& take) {
    if (opencr::isPong(packet) && settle(Request::kSync)) return take({.stamp = taken()});
    if (opencr::isDone(packet)) {
      if (settle(Request::kOther)) return;
      if (settle(Request::kSpeeds)) take({.stamp = taken(), .has_speed = true});
      return;
    }
    const auto table = opencr::parseTable(packet);
    if (!table || !settle(Request::kCounts)) return;
    take({.stamp = taken(),
          .restarted = time_.add(table->millis, now).restarted,
          .counts = table->counts,
          .turn_rate = table->turn_rate,
          .bumped = table->bumped,
          .battery = static_cast<float>(table->battery)});
  }

  double half_track_;  // [m]
  opencr::Decoder frames_;
  DeviceTime time_{1ms};  // the board's own, for whether it was reset
  Timestamp next_beat_{};
  std::uint8_t heartbeat_ = 0;
};

}  // namespace

std::unique_ptr<BaseProtocol> makeOpencrProtocol(const BaseProtocolConfig& config) {
  return std::make_unique<OpencrProtocol>(config);
}

}  // namespace slam
