// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware_if/slamd_base/base_control.hpp"
#include "firmware_if/slamd_base/base_frame.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;

constexpr Duration kStatePeriod = Duration(1s) / slamd_base::kStateRate;
constexpr slamd_base::ControlGains kGains{.most = 3000.0F, .proportional = 0.8F, .integral = 4.0F};  // as delivered

/// A base with the reference firmware, whose own code decides here what is driven and sent. Its motors have at once the
/// speed that is wanted of them.
class FrameEmulator : public CountingBase {
 public:
  FrameEmulator() : CountingBase(geometryOf("frame"), {INT32_MAX - 50, INT32_MIN + 40}) { use(); }  // both soon wrap
  bool inject(std::string_view kind, double value) override {
    if (kind == "gyro") return has_gyro_ = value == 0.0, true;  // 1: its cable is off
    return CountingBase::inject(kind, value);
  }

 protected:
  void restart() override {
    setCountsBack();
    receiver_.reset();
    control_ = slamd_base::BaseControl(kGains);
    started_ = now();
    first_stamp_ = 0;
    use();
  }
  void take(std::uint8_t byte, Bytes&) override {
    receiver_.push(byte, [this](const std::uint8_t* frame) {
      slamd_base::Speeds speeds;
      if (slamd_base::parseSpeeds(frame, &speeds)) control_.command(speeds, micros(now()));
    });
  }
  void send(Bytes& out) override {
    if (started_ == Timestamp{}) started_ = now();
    const auto all = counts();
    const std::int32_t words[2] = {static_cast<std::int32_t>(all[0]), static_cast<std::int32_t>(all[1])};
    for (next_ = std::max(next_, now() - kStatePeriod); next_ <= now(); next_ += kStatePeriod) {
      control_.step(micros(now()), words);
      unsigned flags = 0;
      if (has_gyro_) flags |= slamd_base::kHasGyro;
      if (lifted()) flags |= slamd_base::kLifted;
      if (bumped()) flags |= slamd_base::kBumped;
      if (control_.driven()) flags |= slamd_base::kDriven;
      std::uint8_t frame[slamd_base::kLongestFrame];
      const std::size_t size = slamd_base::encodeState(
          {.stamp = micros(next_),
           .counts = {words[0], words[1]},
           .turn_rate = has_gyro_ ? static_cast<std::int32_t>(std::lround(1e6 * turnRate())) : 0,
           .battery = 12100,
           .speeds = control_.number(),
           .flags = static_cast<std::uint8_t>(flags)},
          frame);
      Outgoing bytes;
      bytes.add({frame, size});
      deliver(bytes, out);
    }
  }
  SideSpeeds sides() const override {
    const double count = 2.0 * std::numbers::pi * geometry().base.wheel_radius / geometry().counts_per_turn;  // [m]
    return {count * control_.wanted(0), count * control_.wanted(1)};
  }

 private:
  /// Of its clock, which soon wraps.
  std::uint32_t micros(Timestamp at) const { return first_stamp_ + static_cast<std::uint32_t>((at - started_) / 1us); }

  slamd_base::Receiver receiver_;
  slamd_base::BaseControl control_{kGains};
  Timestamp started_{}, next_{};
  std::uint32_t first_stamp_ = UINT32_MAX - 2'000'000;  // [us]
  bool has_gyro_ = true;
};

}  // namespace

std::unique_ptr<EmulatedBase> makeFrameBase() { return std::make_unique<FrameEmulator>(); }

}  // namespace slam::sim
