// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>

#include "tools/calibrate/wheel_model.hpp"

namespace slam {

/// Directions of the geometry that a set of motions determines, from the eigenvalues of its Fisher information. They
/// are taken in units of the robot's size (each radius in its own, track and lidar position in tracks, yaw in radians),
/// so that an eigenvalue 1/sigma^2 means the same for all.
class Observability {
 public:
  using Vector = RobotGeometry::Vector;
  using Matrix = Eigen::Matrix<double, 6, 6>;

  /// A direction known no better than this is weak, a parameter no better is not determined. In units of the robot's
  /// size: 10 % of a radius or of the track, 6 deg of yaw.
  static constexpr double kMaxSigma = 0.1;

  /// @param information  of RobotGeometry::vector(): sum of J' covariance^-1 J over the motions
  /// @param size         gives the robot's size: the geometry as configured
  Observability(const Matrix& information, const RobotGeometry& size);

  int weakDirections() const { return weak_; }
  /// Moves along the determined directions only.
  /// @return the step that solves information * step = gradient there, with another point's information
  Vector solve(const Matrix& information, const Vector& gradient) const;
  /// Of RobotGeometry::vector(). Along weak directions the sigma is what the information says, but no more than the
  /// robot's size.
  Matrix covariance() const;
  std::array<bool, 6> determined() const;

 private:
  Vector size_;         // of each parameter [m, m, m, m, m, rad]
  Matrix directions_;   // columns, by growing eigenvalue, in units of size_
  Vector eigenvalues_;  // [1]
  int weak_ = 0;        // the first so many directions
};

/// The degenerate drives of [Censi 2013] (see wheel_model.hpp), in which part of the geometry has no effect.
enum class DriveKind { kVaried, kStraight, kOnTheSpot, kOneArc };
DriveKind driveKind(std::span<const LidarMotion> motions, const RobotGeometry& geometry);

/// What such a drive leaves open and how to fix it, in a sentence.
const char* describe(DriveKind kind);

}  // namespace slam
