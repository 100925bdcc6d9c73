// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "frontend/front_end.hpp"
#include "graph/keyframe_graph.hpp"
#include "support/simulated/robot.hpp"

namespace slam::test {

/// A robot with a front end, whose map begins where the robot stands at its first scan, at T_map_base of `start`.
class Drive : public SimulatedRobot {
 public:
  /// In a bare room, at 5.6 Hz, with the gyro's usual bias and noise.
  explicit Drive(const FrontEndConfig& config = {}) : Drive(Room{.length = 8.0, .width = 5.0}, config) {
    gyro = {.bias = 0.01, .sigma = 0.001};
    lidar.every = 9;
  }
  template <typename World>
  Drive(World world, const FrontEndConfig& config, const FrontEndStart& start = {})
      : SimulatedRobot(std::move(world)), front_end(std::make_unique<FrontEnd>(config, nullptr, start)) {}

  void run(double seconds, const Eigen::Vector3d& twist) { SimulatedRobot::run(seconds, twist, *this); }
  void add(WheelSample sample) {
    sample.lifted = lifted;
    front_end->add(sample);
  }
  void add(const ImuSample& sample) { front_end->add(sample); }
  void add(const LaserScan& measured) {
    if (!frozen) seen_ = measured;
    LaserScan scan = seen_;
    scan.stamp = measured.stamp;
    if (rearrange) rearrange(scan);
    last = front_end->add(scan);
    if (copied_after > Duration(0)) {
      scan.stamp += copied_after;
      front_end->add(scan);
    }
    if (keyframes && last.keyframe && !last.keyframe->refresh) keyframes->add(*last.keyframe);
  }

  double error() const {
    const Pose2 difference = between(truth, front_end->estimate(now).T_map_base);
    return std::hypot(difference.x, difference.y);
  }
  LocalisationState state() const { return front_end->estimate(now).state; }
  double speedError(const Eigen::Vector3d& twist) const {
    return std::abs(front_end->estimate(now).twist.vx - twist.x());
  }

  std::unique_ptr<FrontEnd> front_end;
  ScanOutcome last;
  bool lifted = false;       // a wheel hangs in the air
  bool frozen = false;       // the lidar shows one turn again and again
  Duration copied_after{0};  // a scan is sent once more, so much later
  std::function<void(LaserScan&)> rearrange;
  KeyframeGraph* keyframes = nullptr;  // takes what the front end keeps

 private:
  LaserScan seen_;
};

inline const Eigen::Vector3d kStand(0, 0, 0), kCurve(0.3, 0, 0.4), kSpin(0, 0, 2.0);

}  // namespace slam::test
