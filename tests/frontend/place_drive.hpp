// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <utility>
#include <vector>

#include "frontend/drive.hpp"
#include "matching/places.hpp"

namespace slam::test {

/// In a place, with exact wheels and gyro, and with what the front end keeps.
class PlaceDrive : public Drive {
 public:
  explicit PlaceDrive(Place place, const FrontEndConfig& config = {}, const FrontEndStart& start = {})
      : Drive(std::move(place), withNoise(config), start) {}

  /// What a keyframe or look says, when it was made.
  struct Kept {
    Timestamp stamp;
    Pose2 truth, T_map_base, T_previous_base;
    Eigen::Matrix3d step_covariance, covariance;
    bool look;
    int observable;
  };

  void run(double seconds, const Eigen::Vector3d& twist) { SimulatedRobot::run(seconds, twist, *this); }
  using Drive::add;
  void add(const LaserScan& scan) {
    Drive::add(scan);
    if (const Keyframe* keyframe = last.keyframe) {
      kept.push_back({now, truth, keyframe->T_map_base, keyframe->T_previous_base, keyframe->step_covariance,
                      keyframe->covariance, keyframe->refresh, keyframe->observable});
    }
  }
  std::vector<Kept> kept;

 private:
  static FrontEndConfig withNoise(FrontEndConfig config) {
    config.lidar.range_sigma = 0.01;
    return config;
  }
};

}  // namespace slam::test
