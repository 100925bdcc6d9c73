// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/robot/robot_model.hpp"

#include <cmath>
#include <numbers>

namespace slam::sim {
namespace {

constexpr double kGravity = 9.80665;            // [m/s^2]
constexpr double kGyroCount = 0.001064225;      // [rad/s] per count of the MPU6050
constexpr double kAccelCount = 0.000244 * 9.8;  // [m/s^2] per count

double quantised(double value, double step) { return step * std::round(value / step); }

}  // namespace

RobotModel::RobotModel(const RobotErrors& errors, std::uint64_t seed, const DifferentialBase& nominal)
    : errors_(errors), random_(seed) {
  for (Wheel& wheel : wheels_)
    wheel.true_radius = nominal.wheel_radius * (1.0 + errors.wheel_radius * normal_(random_));
  true_half_track_ = nominal.half_track * (1.0 + errors.track * normal_(random_));
  gyro_scale_ = 1.0 + errors.gyro_scale * normal_(random_);
  gyro_bias_ = errors.gyro_bias * normal_(random_);
}

void RobotModel::step(const Twist2& command, double dt) {
  acceleration_ = (command.vx - twist_.vx) / dt;
  twist_ = command;
  pose_ = pose_ * exp({command.vx * dt, 0.0, command.omega * dt});
  gyro_bias_ += errors_.gyro_bias_walk * std::sqrt(dt) * normal_(random_);

  // The drive's controller makes the base move as commanded; the wheels turn as their true geometry asks, and spin on
  // top of that while they slip.
  const bool moving = std::abs(command.vx) + std::abs(command.omega) > 0.01;
  const double speeds[2] = {command.vx - true_half_track_ * command.omega,
                            command.vx + true_half_track_ * command.omega};
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    Wheel& wheel = wheels_[i];
    const double draw = uniform_(random_);
    if (moving && wheel.slipping <= 0.0 && draw < dt / errors_.slip_interval) {
      wheel.slipping = errors_.slip_time;
      ++slips_;
    }
    const double factor = wheel.slipping > 0.0 ? 1.0 + errors_.slip_factor : 1.0;
    wheel.angle += factor * speeds[i] / wheel.true_radius * dt;
    wheel.slipping -= dt;
  }
}

void RobotModel::carry(const Pose2& T_world_base, double dt) {
  acceleration_ = 0.0;
  twist_ = {0.0, 0.0, wrapAngle(T_world_base.theta - pose_.theta) / dt};
  pose_ = T_world_base;
}

std::array<double, 2> RobotModel::encoderAngles() const {
  constexpr double kCount = 2.0 * std::numbers::pi / kCountsPerTurn;
  return {kCount * std::floor(wheels_[0].angle / kCount), kCount * std::floor(wheels_[1].angle / kCount)};
}

ImuReading RobotModel::readImu() {
  ImuReading reading;
  const double true_gyro[3] = {0.0, 0.0, twist_.omega};
  const double true_accel[3] = {acceleration_, twist_.vx * twist_.omega, kGravity};
  for (std::size_t i = 0; i < 3; ++i) {
    const double bias = i == 2 ? gyro_bias_ : 0.0, scale = i == 2 ? gyro_scale_ : 1.0;
    reading.gyro[i] = quantised(scale * true_gyro[i] + bias + errors_.gyro_noise * normal_(random_), kGyroCount);
    reading.accel[i] = quantised(true_accel[i] + errors_.accel_noise * normal_(random_), kAccelCount);
  }
  return reading;
}

}  // namespace slam::sim
