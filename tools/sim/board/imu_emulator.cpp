// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/board/imu_emulator.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_if/hfi_imu.hpp"
#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2] of one g

/// @param unit what one count means, in the unit of `values`
hfi::B6Frame counts(hfi::B6Type type, const std::array<double, 3>& values, double unit) {
  hfi::B6Frame frame{type};
  for (std::size_t i = 0; i < 3; ++i) {
    frame.raw[i] = static_cast<std::int16_t>(std::clamp(std::round(values[i] / unit), -32768.0, 32767.0));
  }
  return frame;
}

}  // namespace

bool ImuEmulator::inject(std::string_view kind, double value) {
  using E = ImuEmulator;
  static constexpr FaultKind<E> kKinds[] = {
      {"silent", &E::silent_},                       // sends nothing
      {"garbage", &E::garbage_},                     // sends random bytes, as many as otherwise
      {"checksum", &E::wrong_checksums_, 0.0, 1e6},  // so many frames have a wrong checksum
      {"stuck", &E::stuck_},                         // sends the same values for ever
      {"slow", &E::slow_, 1.0, 1000.0},              // only each n-th sample comes
      {"no_accel", &E::no_accel_},                   // a B6 whose acceleration is switched off
      {"wrong", &E::factor_, -1e9, 1e9},             // turn rates are multiplied by it
  };
  return injectFault(kKinds, *this, kind, value);
}

void ImuEmulator::send(std::span<std::uint8_t> frame, std::vector<std::uint8_t>& out) {
  if (wrong_checksums_ > 0) {
    --wrong_checksums_;
    ++frame.back();
  }
  if (garbage_) std::generate(frame.begin(), frame.end(), [this] { return static_cast<std::uint8_t>(random_()); });
  out.insert(out.end(), frame.begin(), frame.end());
}

void ImuEmulator::sample(const std::array<double, 3>& gyro, const std::array<double, 3>& accel,
                         std::vector<std::uint8_t>& out) {
  if (!stuck_) {
    for (std::size_t i = 0; i < 3; ++i) gyro_[i] = factor_ * gyro[i];
    accel_ = accel;
  }
  if (silent_ || ++samples_ % slow_ != 0) return;
  std::array<double, 3> gravity{};  // [g], the unit's sign
  for (std::size_t i = 0; i < 3; ++i) gravity[i] = -accel_[i] / kStandardGravity;
  if (framing_ == Framing::kA9) {
    hfi::A9Motion motion;
    for (std::size_t i = 0; i < 3; ++i) {
      motion.gyro[i] = static_cast<float>(gyro_[i]);
      motion.accel[i] = static_cast<float>(gravity[i]);
    }
    auto motion_frame = hfi::encodeA9(motion);
    auto attitude_frame = hfi::encodeA9(hfi::A9Attitude{});
    send(motion_frame, out);
    send(attitude_frame, out);
    return;
  }
  for (const hfi::B6Frame& frame : {counts(hfi::B6Type::kAccel, gravity, static_cast<double>(hfi::kB6Accel)),
                                    counts(hfi::B6Type::kGyro, gyro_, static_cast<double>(hfi::kB6Gyro)),
                                    hfi::B6Frame{hfi::B6Type::kAngle}, hfi::B6Frame{hfi::B6Type::kMagnetic}}) {
    if (no_accel_ && frame.type == hfi::B6Type::kAccel) continue;
    auto bytes = hfi::encodeB6(frame);
    send(bytes, out);
  }
}

}  // namespace slam::sim
