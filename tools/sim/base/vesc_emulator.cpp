// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <numbers>

#include "drivers/base/base_facts.hpp"
#include "firmware_if/vesc/vesc_packets.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

using Payload = std::span<const std::uint8_t>;

/// Two VESCs: the left wheel's at the port, the right one's on its CAN. Each releases its motor a second after the last
/// command.
class VescEmulator : public CountingBase {
 public:
  VescEmulator() : CountingBase(geometryOf("vesc"), {INT32_MAX - 50, INT32_MIN + 40}) {}  // both soon wrap
  bool inject(std::string_view kind, double value) override {
    if (kind == "cut") return cut_ = value != 0.0, true;                          // the CAN between them
    if (kind == "fault") return fault_ = static_cast<std::uint8_t>(value), true;  // its code, of the right one
    return CountingBase::inject(kind, value);
  }

 protected:
  void restart() override {
    setCountsBack();
    frames_.reset();
    motors_ = {};
  }
  void take(std::uint8_t byte, Bytes& out) override {
    frames_.push(byte, [&](Payload frame) {
      use();
      const Payload payload = vesc::payloadOf(frame);
      const vesc::Forwarded forwarded = vesc::parseForward(payload);
      if (forwarded.payload.empty()) return obey(0, payload, out);
      if (forwarded.id == kIds[1] && !cut_) obey(1, forwarded.payload, out);
    });
  }
  SideSpeeds sides() const override { return {speedOf(0), fault_ == 0 ? speedOf(1) : 0.0}; }

 private:
  static constexpr std::array<std::uint8_t, 2> kIds = BaseProtocolConfig{}.nodes;  // left, right
  struct Motor {
    double speed = 0.0;  // [m/s] of its wheel
    Timestamp commanded{};
  };

  double speedOf(std::size_t side) const {
    return now() - motors_[side].commanded < fromSeconds(vesc::kTimeout) ? motors_[side].speed : 0.0;
  }
  void obey(std::size_t side, Payload payload, Bytes& out) {
    if (vesc::isAskVersion(payload)) return deliver(vesc::encodeVersion(), out);
    if (const auto turn = vesc::parseAskValues(payload)) {
      const auto tachometer = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts()[side]));
      return deliver(vesc::encodeValues({.turn = *turn,
                                         .voltage = 241,
                                         .tachometer = tachometer,
                                         .fault = side == 1 ? fault_ : std::uint8_t{0},
                                         .id = kIds[side]}),
                     out);
    }
    const auto erpm = vesc::parseSetRpm(payload);
    if (!erpm) return;
    const double count = 2.0 * std::numbers::pi * geometry().base.wheel_radius / geometry().counts_per_turn;  // [m]
    motors_[side] = {count * *erpm / vesc::kErpmPerStep, now()};
  }

  vesc::Decoder frames_;
  std::array<Motor, 2> motors_;
  bool cut_ = false;
  std::uint8_t fault_ = 0;
};

}  // namespace

std::unique_ptr<EmulatedBase> makeVesc() { return std::make_unique<VescEmulator>(); }

}  // namespace slam::sim
