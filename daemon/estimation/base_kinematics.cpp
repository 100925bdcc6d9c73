// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/base_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam {
namespace {

constexpr double kSin60 = std::numbers::sqrt3 / 2.0;

Eigen::Vector3d differentialTwist(std::span<const double> wheels, double R) {
  const bool two_axles = wheels.size() == 4;
  const double left = two_axles ? (wheels[0] + wheels[2]) / 2.0 : wheels[0];
  const double right = two_axles ? (wheels[1] + wheels[3]) / 2.0 : wheels[1];
  return {(left + right) / 2.0, 0.0, (right - left) / (2.0 * R)};
}

}  // namespace

int wheelCount(BaseType type) {
  switch (type) {
    case BaseType::kOmni3:
      return 3;
    case BaseType::kMecanum4:
      return 4;
    default:
      return 2;
  }
}

WheelVector wheelsOf(const BaseKinematics& base, const Eigen::Vector3d& twist) {
  const double x = twist.x() / base.wheel_radius, y = twist.y() / base.wheel_radius;
  const double turn = base.body_radius * twist.z() / base.wheel_radius;
  switch (base.type) {
    case BaseType::kOmni3:
      return {y + turn, -kSin60 * x - y / 2.0 + turn, kSin60 * x - y / 2.0 + turn, 0.0};
    case BaseType::kMecanum4:
      return {-x + y + turn, x + y + turn, x - y + turn, -x - y + turn};
    default:
      return {x - turn, x + turn, x - turn, x + turn};
  }
}

Eigen::Vector3d twistOf(const BaseKinematics& base, std::span<const double> wheels) {
  const double R = base.body_radius;
  const auto& m = wheels;
  switch (base.type) {
    case BaseType::kOmni3:
      return base.wheel_radius * Eigen::Vector3d{(m[2] - m[1]) / (2.0 * kSin60), (2.0 * m[0] - m[1] - m[2]) / 3.0,
                                                 (m[0] + m[1] + m[2]) / (3.0 * R)};
    case BaseType::kMecanum4:
      return base.wheel_radius / 4.0 *
             Eigen::Vector3d{-m[0] + m[1] + m[2] - m[3], m[0] + m[1] - m[2] - m[3], (m[0] + m[1] + m[2] + m[3]) / R};
    default:
      return base.wheel_radius * differentialTwist(wheels, R);
  }
}

double unexplained(const BaseKinematics& base, std::span<const double> wheels) {
  const WheelVector explained = wheelsOf(base, twistOf(base, wheels));
  double worst = 0.0;
  for (std::size_t i = 0; i < wheels.size(); ++i) worst = std::max(worst, std::abs(wheels[i] - explained[i]));
  // With as many wheels as directions what is left is rounding.
  return static_cast<int>(wheels.size()) > (base.type == BaseType::kDifferential ? 2 : 3) ? worst * base.wheel_radius
                                                                                          : 0.0;
}

}  // namespace slam
