// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <random>
#include <vector>

#include "tools/calibrate/wheel_model.hpp"

namespace slam::test {

inline const RobotGeometry kRobot{
    .left_radius = 0.0331, .right_radius = 0.0327, .track = 0.322, .T_base_lidar = {0.071, -0.024, 0.13}};
/// What one would believe of it: a percent off, and the lidar by some centimetres and degrees.
inline const RobotGeometry kBelieved{
    .left_radius = 0.033, .right_radius = 0.033, .track = 0.318, .T_base_lidar = {0.05, 0.0, 0.0}};

inline constexpr double kTranslationSigma = 0.002, kRotationSigma = 0.001;  // [m], [rad] of a motion

enum class Drive { kVaried, kStraight, kOnTheSpot, kOneArc };

/// Makes motions of kRobot with the noise of a seed.
class MotionMaker {
 public:
  explicit MotionMaker(unsigned seed, double noise = 1.0) : random_(seed), noise_(noise) {}

  std::vector<LidarMotion> make(Drive drive, int count) {
    std::vector<LidarMotion> motions;
    for (int i = 0; i < count; ++i) motions.push_back(motion(drive));
    return motions;
  }

  /// The left wheel spins on top of what the motion needs.
  static void slip(LidarMotion& motion) {
    for (WheelStep& step : motion.wheels) step.left *= 1.25;
  }

 private:
  static constexpr int kSteps = 8;

  double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  double gauss(double sigma) { return noise_ * std::normal_distribution<double>(0.0, sigma)(random_); }

  LidarMotion motion(Drive drive) {
    LidarMotion motion;
    const bool straight = uniform(0.0, 1.0) < 0.5;
    double travel = 0.0, turn = 0.0;  // [m], [rad]
    if (drive == Drive::kVaried) travel = uniform(0.2, 0.4), turn = straight ? 0.0 : uniform(-0.8, 0.8);
    if (drive == Drive::kStraight) travel = straight ? 0.3 : -0.4;
    if (drive == Drive::kOnTheSpot) turn = straight ? 0.4 : -0.5;
    if (drive == Drive::kOneArc) travel = 0.3, turn = 0.4;
    for (int i = 0; i < kSteps; ++i) {
      motion.wheels.push_back({(travel - kRobot.track / 2.0 * turn) / kRobot.left_radius / kSteps,
                               (travel + kRobot.track / 2.0 * turn) / kRobot.right_radius / kSteps});
    }
    motion.T_begin_end = predictPose(kRobot, motion.wheels);
    motion.T_begin_end.x += gauss(kTranslationSigma);
    motion.T_begin_end.y += gauss(kTranslationSigma);
    motion.T_begin_end.theta += gauss(kRotationSigma);
    motion.covariance = Eigen::Vector3d(kTranslationSigma, kTranslationSigma, kRotationSigma).cwiseAbs2().asDiagonal();
    return motion;
  }

  std::mt19937 random_;
  double noise_;
};

}  // namespace slam::test
