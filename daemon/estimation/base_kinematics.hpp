// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace slam {

enum class BaseType : std::uint8_t { kDifferential, kOmni3, kMecanum4 };

inline constexpr int kMaxWheels = 4;

/// Geometry of a wheeled base. A base is described by what its wheels turn when it moves:
///
/// | type         | wheels                     | linear speeds of the wheels, R = body_radius                       |
/// |--------------|----------------------------|--------------------------------------------------------------------|
/// | differential | left, right (left, right)  | vx - R w, vx + R w (and the same again for a second axle)          |
/// | omni3        | servo 1..3 of the firmware | vy + R w; -s vx - vy/2 + R w; s vx - vy/2 + R w with s = sqrt(3)/2 |
/// | mecanum4     | servo 1..4 of the firmware | -vx + vy + R w; vx + vy + R w; vx - vy + R w; -vx - vy + R w       |
///
/// Both wheels of a differential base count positive driving forward. [HandsFree OpenRE, 2_Package/robot_control/tf]
struct BaseKinematics {
  BaseType type = BaseType::kDifferential;
  double wheel_radius = 0.0325;  ///< [m]
  double body_radius = 0.10075;  ///< [m] differential: half the track; omni3: centre to wheel; mecanum4: half the track
                                 ///< plus half the wheelbase
};

/// Angles [rad] or speeds [rad/s] of up to four wheels; unused ones are 0.
using WheelVector = std::array<double, kMaxWheels>;

/// @return wheels that say all about the motion of such a base
int wheelCount(BaseType type);

/// @param twist (vx [m/s], vy [m/s], omega [rad/s]) of base, or their integrals over a time; a differential base cannot
///              do vy, it is left out
/// @return what the wheels turn [rad/s], or [rad]; all four for a differential base
WheelVector wheelsOf(const BaseKinematics& base, const Eigen::Vector3d& twist);

/// Inverse of wheelsOf(), least squares where there are more wheels than directions.
/// @param wheels as many as wheelCount(), or two axles of a differential base, which are averaged side by side
Eigen::Vector3d twistOf(const BaseKinematics& base, std::span<const double> wheels);

/// @return [m/s] or [m] largest share of a wheel's turning that no motion of the base explains: a hint of slip. Always
/// 0
///         with as many wheels as directions
double unexplained(const BaseKinematics& base, std::span<const double> wheels);

}  // namespace slam
