// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/board/imu_emulator.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/imu/codec/witmotion_frames.hpp"
#include "firmware_if/hfi_imu.hpp"

namespace slam::sim {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2] of one g

/// @param unit what one count means, in the unit of `values`
witmotion::Frame counts(witmotion::Type type, const std::array<double, 3>& values, double unit) {
  witmotion::Frame frame{type};
  for (std::size_t i = 0; i < 3; ++i) {
    frame.raw[i] = static_cast<std::int16_t>(std::clamp(std::round(values[i] / unit), -32768.0, 32767.0));
  }
  return frame;
}

}  // namespace

void ImuEmulator::encode(const Vector& gyro, const Vector& accel, Bytes& out) {
  Vector gravity{};  // [g], the unit's sign
  for (std::size_t i = 0; i < 3; ++i) gravity[i] = -accel[i] / kStandardGravity;
  if (framing_ == Framing::kA9) {
    hfi::A9Motion motion;
    for (std::size_t i = 0; i < 3; ++i) {
      motion.gyro[i] = static_cast<float>(gyro[i]);
      motion.accel[i] = static_cast<float>(gravity[i]);
    }
    send(hfi::encodeA9(motion), out);
    send(hfi::encodeA9(hfi::A9Attitude{}), out);
    return;
  }
  using witmotion::Type;
  if (sendsAcceleration())
    send(witmotion::encode(counts(Type::kAcceleration, gravity, witmotion::kGravitiesPerCount)), out);
  if (sendsTurnRate())
    send(witmotion::encode(counts(Type::kTurnRate, gyro, witmotion::kRadiansPerSecondPerCount)), out);
  for (const Type type : {Type::kAngle, Type::kMagnetic}) send(witmotion::encode({type}), out);
}

}  // namespace slam::sim
