// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/imu/codec/bno08x_frames.hpp"
#include "tools/sim/imu/faulty_imu.hpp"
#include "tools/sim/imu/imu_emulators.hpp"

namespace slam::sim {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2] of one g

std::int16_t counts(double value) {
  return static_cast<std::int16_t>(std::clamp(std::round(value), -32768.0, 32767.0));
}

class Bno08xEmulator : public FaultyImu {
 protected:
  void renew(const Vector& gyro) override {
    heading_ = std::remainder(heading_ + gyro[2] * toSeconds(kPeriod), 2.0 * std::numbers::pi);
  }
  void encode(const Vector&, const Vector& accel, Bytes& out) override {
    bno08x::Frame frame{.index = index_++,
                        .yaw = counts(heading_ * 180.0 / std::numbers::pi / bno08x::kDegreesPerCount)};
    for (std::size_t i = 0; i < 3; ++i)
      frame.acceleration[i] = counts(accel[i] / kStandardGravity / bno08x::kGravitiesPerCount);
    send(bno08x::encode(frame), out);
  }

 private:
  double heading_ = 0.0;  // [rad]
  std::uint8_t index_ = 0;
};

}  // namespace

std::unique_ptr<EmulatedImu> makeBno08x() { return std::make_unique<Bno08xEmulator>(); }

}  // namespace slam::sim
