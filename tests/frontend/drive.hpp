// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>

#include "frontend/front_end.hpp"
#include "graph/keyframe_graph.hpp"
#include "support/simulated/room.hpp"

namespace slam::test {

/// Drives a robot with wheels, gyro and a lidar in a room, in virtual time.
class Drive {
 public:
  explicit Drive(const FrontEndConfig& config = {}) : front_end(std::make_unique<FrontEnd>(config)) {}

  bool wheels = true, imu = true, lidar = true;
  int scan_every = 9;         // of the wheels' samples: 5.6 Hz
  double wheel_factor = 1.0;  // 0: the wheels do not see the motion
  double gyro_offset = 0.0;   // [rad/s] beside the usual bias
  Room room{.length = 8.0, .width = 5.0, .range_sigma = 0.01};
  std::unique_ptr<FrontEnd> front_end;
  Pose2 truth;
  Timestamp now{std::chrono::seconds(100)};
  std::function<void(LaserScan&)> rearrange;
  KeyframeGraph* keyframes = nullptr;  // takes what the front end keeps

  void run(double seconds, const Eigen::Vector3d& twist) {
    const Timestamp end = now + fromSeconds(seconds);
    while (now < end) {
      now += std::chrono::milliseconds(20);
      truth = truth * exp(0.02 * twist);
      dead_reckoned_ = dead_reckoned_ * exp(0.02 * wheel_factor * twist);
      if (wheels) front_end->add(WheelSample{now, dead_reckoned_});
      if (imu)
        front_end->add(ImuSample{now, {0, 0, twist.z() + 0.01 + gyro_offset + 0.001 * noise_(random_)}, {0, 0, 9.81}});
      if (lidar && ++step_ % scan_every == 0) {
        if (!frozen) seen_ = turning ? turn(twist) : stopped();
        LaserScan scan = seen_;
        scan.stamp = turning ? scan.stamp : now;
        if (rearrange) rearrange(scan);
        last = front_end->add(scan);
        if (copied_after > Duration(0)) {
          scan.stamp += copied_after;
          front_end->add(scan);
        }
        if (keyframes && last.keyframe && !last.keyframe->refresh) keyframes->add(*last.keyframe);
      }
    }
  }
  /// The wheels claim a motion that was none.
  void pretend(const Pose2& jump) { dead_reckoned_ = dead_reckoned_ * jump; }
  double error() const {
    const Pose2 difference = between(truth, front_end->estimate(now).T_map_base);
    return std::hypot(difference.x, difference.y);
  }
  LocalisationState state() const { return front_end->estimate(now).state; }
  double speedError(const Eigen::Vector3d& twist) const {
    return std::abs(front_end->estimate(now).twist.vx - twist.x());
  }
  ScanOutcome last;
  bool frozen = false;       // the lidar shows one turn again and again
  Duration copied_after{0};  // a scan is sent once more, so much later
  bool turning = false;      // the lidar takes its time over a turn, as real ones do

 private:
  LaserScan stopped() {
    LaserScan scan = room.scan(truth, random_);
    scan.stamp = now;
    return scan;
  }
  /// A turn that ends now, while the robot moves.
  LaserScan turn(const Eigen::Vector3d& twist) {
    constexpr double kTurn = 0.18;  // [s]
    LaserScan scan;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(room.reach);
    scan.stamp = now - fromSeconds(kTurn);
    for (int i = 0; i < room.beams; ++i) {
      const double share = static_cast<double>(i) / room.beams, bearing = wrapAngle(2.0 * std::numbers::pi * share);
      const double range = room.range(truth * exp(kTurn * (share - 1.0) * twist), bearing);
      scan.push({.range = static_cast<float>(range + room.range_sigma * noise_(random_)),
                 .bearing = static_cast<float>(bearing),
                 .time_offset = static_cast<float>(kTurn * share)});
    }
    return scan;
  }

  Pose2 dead_reckoned_;
  LaserScan seen_;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, 1.0};
  int step_ = 0;
};

inline const Eigen::Vector3d kStand(0, 0, 0), kCurve(0.3, 0, 0.4), kSpin(0, 0, 2.0);

}  // namespace slam::test
