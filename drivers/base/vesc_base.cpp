// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/base/base_protocols.hpp"
#include "firmware_if/vesc/vesc_packets.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using vesc::Turn;
using vesc::Values;

constexpr Duration kVescPeriod = 20ms;   // of asking both: 44 bytes of answers, 4 ms at 115200 bit/s
constexpr Duration kVescAnswer = 100ms;  // a question that is not answered by then is lost
constexpr Duration kVescAway = 300ms;    // one that has not answered for so long is gone: the other one must not drive
constexpr Duration kVescForgotten = 1s;  // the one at the port, silent for so long, may be another one by now
constexpr Duration kVescTravel = 1ms;    // of a question: bytes, and a frame of the USB
constexpr int kSameId = 3;               // answers in a row, and the VESC at the port is known by its id
constexpr int kVescZeros = 3;            // sent one behind the other: one of them has arrived at both
constexpr double kVescMostErpm = 1e9;    // [1/min]
constexpr const char* kVescSides[] = {"left", "right"};

/// Two VESCs: one at the port, which forwards to the other one over CAN. Each answer has its id and the turn of its
/// question, so that none is taken for another. No answer acknowledges a speed: a zero is known to have arrived when it
/// was sent three times and both have answered a question behind it.
class VescProtocol : public BaseProtocol {
 public:
  explicit VescProtocol(const BaseProtocolConfig& config)
      : counts_per_metre_(config.counts_per_turn / (2.0 * std::numbers::pi * config.wheel_radius)),
        ids_(config.nodes) {}

  void begin(Timestamp now) override {
    frames_.reset();
    at_port_.reset();
    same_id_ = zeros_ = 0;
    for (Side& side : sides_) side = {};
    requested_ = {};
    next_ = now;
  }

  Outgoing question(Timestamp now) override {
    const bool is_open = requested_ != Timestamp{} && !isAnswered();
    if (now < next_ || (is_open && now - requested_ < kVescAnswer)) return {};
    unanswered_ += is_open ? 1 : 0;
    if (at_port_ && now - sides_[*at_port_].answered > kVescForgotten) {
      at_port_.reset();
      same_id_ = 0;
    }
    turn_ = turn_ == Turn::kEven ? Turn::kOdd : Turn::kEven;
    requested_ = now;
    next_ = std::max(next_ + kVescPeriod, now);
    for (Side& side : sides_) side.has_answered = false;
    Outgoing out = vesc::askValues(turn_);
    if (at_port_) out.add(vesc::forward(ids_[other()], vesc::askValues(turn_)).bytes());
    return out;
  }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    frames_.push(byte, [&](std::span<const std::uint8_t> frame) {
      const auto values = vesc::parseValues(frame);
      if (values && values->turn == turn_ && handle(*values, now, take)) return;
      ++other_;
    });
  }

  /// As long as one of them is not known, does not answer or has a fault, both get a zero.
  Outgoing speeds(const SideSpeeds& wanted, Timestamp now) override {
    const SideSpeeds given = mayTurn(now) ? wanted : SideSpeeds{};
    zeros_ = given.isZero() ? zeros_ + 1 : 0;
    if (zeros_ == kVescZeros) last_zero_ = now;
    const std::array<Outgoing, 2> speeds = {vesc::setRpm(erpmOf(given.left)), vesc::setRpm(erpmOf(given.right))};
    if (!at_port_) {
      zeros_ = 0;  // nobody is known who could have it
      Outgoing out = speeds[0];
      for (const std::uint8_t id : ids_) out.add(vesc::forward(id, speeds[0]).bytes());
      return out;
    }
    Outgoing out = speeds[*at_port_];
    out.add(vesc::forward(ids_[other()], speeds[other()]).bytes());
    return out;
  }
  std::uint32_t damage() const override { return frames_.damaged() + unanswered_ + other_; }

 private:
  struct Side {
    Timestamp answered{};
    bool has_answered = false;  // the question that is under way
    Values values{};
  };

  std::size_t other() const { return 1 - *at_port_; }
  bool isAnswered() const {
    return at_port_ ? sides_[0].has_answered && sides_[1].has_answered : sides_[0].has_answered;
  }
  bool mayTurn(Timestamp now) const {
    return at_port_ && std::all_of(sides_.begin(), sides_.end(), [&](const Side& side) {
             return now - side.answered <= kVescAway && side.values.fault == 0;
           });
  }
  std::int32_t erpmOf(double speed) const {
    const double erpm = vesc::kErpmPerStep * counts_per_metre_ * speed;
    return static_cast<std::int32_t>(std::lround(std::clamp(erpm, -kVescMostErpm, kVescMostErpm)));
  }

  /// @return false: it is of neither
  bool handle(const Values& values, Timestamp now, const Take& take) {
    if (!at_port_) return learn(values, now), true;
    const bool is_at_port = values.id == id_at_port_;
    if (!is_at_port && values.id != ids_[other()]) return false;
    Side& side = sides_[is_at_port ? *at_port_ : other()];
    side = {now, true, values};
    if (isAnswered()) {
      take(reading());
    } else if (now - sides_[other()].answered > kVescAway) {
      take({.stamp = requested_ + kVescTravel,
            .fault = {problem::kVescAway, {static_cast<double>(ids_[other()])}, {kVescSides[other()]}}});
    }
    return true;
  }

  /// Only the one at the port was asked. An answer that another session asked for must not name it.
  void learn(const Values& values, Timestamp now) {
    same_id_ = same_id_ > 0 && values.id == id_at_port_ ? same_id_ + 1 : 1;
    id_at_port_ = values.id;
    sides_[0].has_answered = true;
    if (same_id_ < kSameId) return;
    at_port_ = values.id == ids_[1] ? 1 : 0;
    for (Side& side : sides_) side = {.answered = now, .has_answered = true};
  }

  BaseReading reading() const {
    BaseReading reading{.stamp = requested_ + kVescTravel,
                        .counts = std::array{static_cast<std::uint32_t>(sides_[0].values.tachometer),
                                             static_cast<std::uint32_t>(sides_[1].values.tachometer)},
                        .battery = 0.1F * std::max<float>(0.0F, sides_[*at_port_].values.voltage),
                        .has_speed = zeros_ >= kVescZeros && requested_ >= last_zero_};
    for (std::size_t i = 0; i < 2; ++i) {
      const Values& values = sides_[i].values;
      if (values.fault != 0)
        reading.fault = {
            problem::kVescFault, {static_cast<double>(values.id), static_cast<double>(values.fault)}, {kVescSides[i]}};
    }
    return reading;
  }

  double counts_per_metre_;
  std::array<std::uint8_t, 2> ids_;  // on CAN: left, right
  vesc::Decoder frames_;
  Turn turn_ = Turn::kEven;             // of the question that is under way
  std::optional<std::size_t> at_port_;  // which side's VESC that is: the left one, unless it has the right one's id
  std::uint8_t id_at_port_ = 0;
  std::array<Side, 2> sides_;
  Timestamp requested_{}, next_{}, last_zero_{};
  int same_id_ = 0;  // answers of one id in a row
  int zeros_ = 0;    // sent since the last other speed
  std::uint32_t unanswered_ = 0, other_ = 0;
};

}  // namespace

std::unique_ptr<BaseProtocol> makeVescProtocol(const BaseProtocolConfig& config) {
  return std::make_unique<VescProtocol>(config);
}

}  // namespace slam
