// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "frontend/front_end.hpp"
#include "matching/places.hpp"

namespace slam::test {

/// Drives a front end through a place that may change, in virtual time: exact wheels and gyro, a lidar at 5 Hz. Its map
/// begins where the robot stands at its first scan, at T_map_base of `start`.
class PlaceDrive {
 public:
  explicit PlaceDrive(Place scene, const FrontEndConfig& config = {}, const FrontEndStart& start = {})
      : place(std::move(scene)), front_end(std::make_unique<FrontEnd>(withNoise(config), nullptr, start)) {}

  /// What a keyframe or look says, when it was made.
  struct Kept {
    Timestamp stamp;
    Pose2 truth, T_map_base, T_previous_base;
    Eigen::Matrix3d step_covariance;
    bool look;
    int observable;
  };

  void run(double seconds, const Eigen::Vector3d& twist) {
    for (const Timestamp end = now + fromSeconds(seconds); now < end;) {
      now += std::chrono::milliseconds(20);
      truth = truth * exp(0.02 * twist);
      wheels = wheels * exp(0.02 * twist);
      if (has_wheels) front_end->add(WheelSample{now, wheels});
      if (has_imu) front_end->add(ImuSample{now, {0, 0, twist.z()}, {0, 0, 9.81}});
      if (++step_ % 10 == 0) scan();
    }
  }
  void scan() {
    LaserScan scan;
    scan.stamp = now;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(place.reach);
    for (int i = 0; i < 360; ++i) {
      const double bearing = wrapAngle(2.0 * std::numbers::pi * i / 360), direction = truth.theta + bearing;
      const auto range =
          place.world.castRay({truth.x, truth.y, 0.2}, {std::cos(direction), std::sin(direction), 0.0}, place.reach);
      scan.push({.range = range ? static_cast<float>(*range + 0.01 * noise_(random_)) : 0.0F,
                 .bearing = static_cast<float>(bearing)});
    }
    last = front_end->add(scan);
    if (const Keyframe* keyframe = last.keyframe) {
      kept.push_back({now, truth, keyframe->T_map_base, keyframe->T_previous_base, keyframe->step_covariance,
                      keyframe->refresh, keyframe->observable});
    }
  }

  Place place;
  Pose2 truth, wheels;  ///< truth may be changed at any time, which wheels and gyro do not see
  Timestamp now{std::chrono::seconds(100)};
  bool has_wheels = true, has_imu = true;
  std::unique_ptr<FrontEnd> front_end;
  ScanOutcome last;
  std::vector<Kept> kept;

 private:
  static FrontEndConfig withNoise(FrontEndConfig config) {
    config.lidar.range_sigma = 0.01;
    return config;
  }
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, 1.0};
  int step_ = 0;
};

}  // namespace slam::test
