// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "drivers/imu/codec/witmotion_frames.hpp"
#include "tools/sim/imu/faulty_imu.hpp"
#include "tools/sim/imu/imu_emulators.hpp"

namespace slam::sim {
namespace {

using witmotion::Frame;
using witmotion::Type;

constexpr double kStandardGravity = 9.80665;  // [m/s^2] of one g

/// @param unit what one count means, in the unit of `values`
Frame counts(Type type, const EmulatedImu::Vector& values, double unit) {
  Frame frame{type};
  for (std::size_t i = 0; i < 3; ++i)
    frame.raw[i] = static_cast<std::int16_t>(std::clamp(std::round(values[i] / unit), -32768.0, 32767.0));
  return frame;
}

class WitmotionEmulator : public FaultyImu {
 protected:
  void encode(const Vector& gyro, const Vector& accel, Bytes& out) override {
    if (sendsAcceleration())
      send(witmotion::encode(counts(Type::kAcceleration, accel, kStandardGravity * witmotion::kGravitiesPerCount)),
           out);
    if (sendsTurnRate())
      send(witmotion::encode(counts(Type::kTurnRate, gyro, witmotion::kRadiansPerSecondPerCount)), out);
    for (const Type type : {Type::kAngle, Type::kMagnetic}) send(witmotion::encode(Frame{type}), out);
  }
};

}  // namespace

std::unique_ptr<EmulatedImu> makeWitmotion() { return std::make_unique<WitmotionEmulator>(); }

}  // namespace slam::sim
