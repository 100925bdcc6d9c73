// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <functional>
#include <random>
#include <utility>

#include "core/samples.hpp"
#include "support/simulated/room.hpp"

namespace slam::test {

/// A robot with wheels, gyro and lidar in a room or a place, in virtual time. Each sample goes to the `add()` that a
/// sink has for it: the sink may be a FrontEnd, a Pipeline, or what a test wants.
class SimulatedRobot {
 public:
  static constexpr Duration kStep = std::chrono::milliseconds(20);  ///< between samples of wheels and gyro

  struct Wheels {
    bool there = true;
    double scale = 1.0, turn_scale = 1.0;  ///< [1] what they tell of the way and of the turn
    double spin = 0.0;                     ///< [m/s] that they tell besides
    double sigma = 0.0, turn_sigma = 0.0;  ///< [m, rad] of each sample
    Pose2 pose = {};                       ///< that they tell

    /// They tell a motion that was none.
    void leap(const Pose2& motion) { pose = pose * motion; }
  };
  struct Gyro {
    bool there = true;
    double bias = 0.0, sigma = 0.0;  ///< [rad/s]
  };
  struct Lidar : SimulatedLidar {
    bool there = true;
    int every = 10;  ///< steps between scans
  };

  template <typename World>
  explicit SimulatedRobot(World world, const Pose2& start = {}, unsigned seed = 1) : truth(start), random(seed) {
    enter(std::move(world));
  }

  /// The robot is in this room or place from now on.
  template <typename World>
  void enter(World world) {
    lidar.reach = world.reach;
    range_ = [world = std::move(world)](const Pose2& pose, double bearing) { return world.range(pose, bearing); };
  }

  template <typename Sink>
  void run(double seconds, const Eigen::Vector3d& twist, Sink&& sink) {
    for (const Timestamp end = now + fromSeconds(seconds); now < end;) step(twist, sink);
  }
  template <typename Sink>
  void step(const Eigen::Vector3d& twist, Sink&& sink) {
    constexpr double kSeconds = toSeconds(kStep);
    now += kStep;
    truth = truth * exp(kSeconds * twist);
    wheels.pose =
        wheels.pose * exp(kSeconds * Eigen::Vector3d(wheels.scale * twist.x() + wheels.spin, wheels.scale * twist.y(),
                                                     wheels.turn_scale * twist.z()));
    if (wheels.there) {
      const double error = noise(wheels.sigma), turn_error = noise(wheels.turn_sigma);
      wheels.pose = wheels.pose * Pose2{error, 0.0, turn_error};
      sink.add(WheelSample{now, wheels.pose});
    }
    if (gyro.there) sink.add(ImuSample{now, {0, 0, twist.z() + gyro.bias + noise(gyro.sigma)}, {0, 0, 9.81}});
    if (++steps_ % lidar.every == 0 && lidar.there) {
      LaserScan scan = lidar.scan(range_, truth, random, twist);
      scan.stamp = now - fromSeconds(lidar.sweep);
      sink.add(scan);
    }
  }

  Wheels wheels;
  Gyro gyro;
  Lidar lidar;
  Pose2 truth;  ///< in the world; may be changed at any time, which wheels and gyro do not see
  Timestamp now{std::chrono::seconds(100)};
  std::mt19937 random;

 private:
  double noise(double sigma) { return sigma > 0.0 ? sigma * normal_(random) : 0.0; }

  std::function<double(const Pose2&, double)> range_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  int steps_ = 0;
};

}  // namespace slam::test
