// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/robot/driver_model.hpp"

#include <algorithm>
#include <cmath>

namespace slam::sim {
namespace {

constexpr double kAcceleration = 0.5;         // [m/s^2]
constexpr double kAngularAcceleration = 2.0;  // [rad/s^2]
constexpr double kAligned = 0.005;            // [rad]
constexpr double kThere = 0.01;               // [m]
constexpr double kPutDown = 1.0;              // [s] standing where it was carried to
constexpr double kSteering = 1.5;             // [1/s] heading correction while driving

/// Speed from which the remaining way can still be braked.
double braking(double way, double deceleration, double limit) {
  return std::clamp(std::sqrt(2.0 * deceleration * std::max(0.0, way)), 0.0, limit);
}

}  // namespace

double DriverModel::approach(double value, double target, double step) const {
  return value + std::clamp(target - value, -step, step);
}

void DriverModel::beginPause(double seconds) {
  phase_ = Phase::kPause;
  wait_ = seconds;
  reported_ = false;
}

void DriverModel::continueFrom(std::size_t waypoint) {
  next_ = waypoint + 1;
  phase_ = Phase::kTurn;
  wait_ = kPutDown;
  twist_ = {};
}

Twist2 DriverModel::command(const Pose2& pose, double dt) {
  reached_ = -1;
  double speed = 0.0, turn = 0.0;
  const bool waiting = phase_ != Phase::kPause && wait_ > 0.0;
  if (waiting) wait_ -= dt;
  if (!finished() && !waiting) {
    const Waypoint& goal = scene_.route[next_];
    const double dx = goal.pose.x - pose.x, dy = goal.pose.y - pose.y, distance = std::hypot(dx, dy);
    const double bearing = wrapAngle(std::atan2(dy, dx) - pose.theta);
    const double align = wrapAngle(goal.pose.theta - pose.theta);
    const auto turnBy = [&](double angle) {
      return std::copysign(braking(std::abs(angle), 0.5 * kAngularAcceleration, scene_.turn_rate), angle);
    };
    switch (phase_) {
      case Phase::kTurn:
        turn = turnBy(bearing);
        if (distance < kThere || (std::abs(bearing) < kAligned && std::abs(twist_.omega) < 0.05))
          phase_ = Phase::kDrive;
        break;
      case Phase::kDrive:
        speed = braking(distance, 0.5 * kAcceleration, scene_.speed) * std::max(0.0, std::cos(bearing));
        turn = distance > 0.1 ? kSteering * bearing : 0.0;
        if (distance < kThere || (distance < 0.2 && std::cos(bearing) < 0.0)) {
          goal.stop ? void(phase_ = Phase::kAlign) : beginPause(goal.pause);
        }
        break;
      case Phase::kAlign:
        turn = turnBy(align);
        if (std::abs(align) < kAligned && std::abs(twist_.omega) < 0.02) beginPause(goal.pause);
        break;
      case Phase::kPause:
        wait_ -= dt;
        if (goal.measured && !reported_ && wait_ < goal.pause / 2) {
          reported_ = true;
          reached_ = static_cast<int>(next_);
        }
        if (wait_ <= 0.0) {
          wait_ = 0.0;
          ++next_;
          phase_ = Phase::kTurn;
        }
        break;
    }
  }
  twist_.vx = approach(twist_.vx, speed, kAcceleration * dt);
  twist_.omega = approach(twist_.omega, turn, kAngularAcceleration * dt);
  return twist_;
}

}  // namespace slam::sim
