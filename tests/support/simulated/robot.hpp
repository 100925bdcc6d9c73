// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <functional>
#include <random>
#include <utility>

#include "core/samples.hpp"
#include "support/simulated/room.hpp"
#include "tools/faults/sensor_faults.hpp"

namespace slam::test {

/// A sink that has an add() for samples of a kind.
template <typename Sink, typename Sample>
concept Takes = requires(Sink& sink, const Sample& sample) {
  sink.add(sample);
};

/// A robot with wheels, gyro and lidar in a room or a place, in virtual time. Each sample goes to the `add()` that a
/// sink has for it: the sink may be a FrontEnd, a Pipeline, or what a test wants.
class SimulatedRobot {
 public:
  static constexpr Duration kStep = std::chrono::milliseconds(20);  ///< between samples of wheels and gyro

  struct Wheels {
    bool there = true;
    double scale = 1.0, turn_scale = 1.0;  ///< [1] what they tell of the way and of the turn
    Eigen::Vector3d spin{0, 0, 0};         ///< [m/s, m/s, rad/s] that they tell besides
    double sigma = 0.0, turn_sigma = 0.0;  ///< [m, rad] of each sample
    Pose2 pose = {};                       ///< that they tell
    Eigen::Vector3d twist{0, 0, 0};        ///< [m/s, m/s, rad/s] of the newest sample

    /// They tell a motion that was none.
    void leap(const Pose2& motion) { pose = pose * motion; }
  };
  struct Gyro {
    bool there = true;
    int per_step = 1;                ///< samples from step to step
    double bias = 0.0, sigma = 0.0;  ///< [rad/s]
    ImuFault fault = {};
    std::function<double(double)> reads = {};  ///< [rad/s] what else it makes of the rate; empty: it is right
  };
  struct Lidar : SimulatedLidar {
    bool there = true;
    int every = 10, ahead = 0;  ///< steps from scan to scan; steps by which they come earlier
  };
  /// Poses that matched scans tell, for a sink that takes poses.
  struct Matches {
    double scale = 1.0, drift = 0.0;  ///< [1] of the way, [rad/s] what scans tell wrongly
    Eigen::Vector3d sigma{0, 0, 0};   ///< [m, m, rad] of each pose
    Pose2 pose = {};                  ///< that they tell
  };

  template <typename World>
  explicit SimulatedRobot(World world, const Pose2& start = {}, unsigned seed = 1) : truth(start), random(seed) {
    matches.pose = start;
    enter(std::move(world));
  }

  /// The robot is in this room or place from now on.
  template <typename World>
  void enter(World world) {
    lidar.reach = world.reach;
    walls_.range = [world = std::move(world)](const Pose2& pose, double bearing) { return world.range(pose, bearing); };
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
    wheels.twist = wheels.spin +
                   Eigen::Vector3d(wheels.scale * twist.x(), wheels.scale * twist.y(), wheels.turn_scale * twist.z());
    wheels.pose = wheels.pose * exp(kSeconds * wheels.twist);
    if (wheels.there) {
      const double error = noise(wheels.sigma), turn_error = noise(wheels.turn_sigma);
      wheels.pose = wheels.pose * Pose2{error, 0.0, turn_error};
      wheels.twist += Eigen::Vector3d(error, 0.0, turn_error) / kSeconds;
      if constexpr (Takes<Sink, WheelSample>) sink.add(WheelSample{now, wheels.pose});
    }
    for (int i = 0; i < gyro.per_step && gyro.there; ++i) {
      const double rate = twist.z() + gyro.bias + noise(gyro.sigma);
      const ImuSample sample{
          now + i * kStep / gyro.per_step, {0, 0, gyro.reads ? gyro.reads(rate) : rate}, {0, 0, 9.81}};
      if constexpr (Takes<Sink, ImuSample>) sink.add(gyro.fault.apply(sample));
    }
    matches.pose =
        matches.pose * exp(kSeconds * Eigen::Vector3d(matches.scale * twist.x(), 0.0, twist.z() + matches.drift));
    if ((++steps_ + lidar.ahead) % lidar.every != 0 || !lidar.there) return;
    if constexpr (Takes<Sink, LaserScan>) {
      LaserScan scan = lidar.scan(walls_, truth, random, twist);
      scan.stamp = now - fromSeconds(lidar.sweep);
      sink.add(scan);
    }
    if constexpr (Takes<Sink, PoseMeasurement>) {
      const Pose2 error{noise(matches.sigma.x()), noise(matches.sigma.y()), noise(matches.sigma.z())};
      sink.add(PoseMeasurement{now, matches.pose * error});
    }
  }

  Wheels wheels;
  Gyro gyro;
  Lidar lidar;
  Matches matches;
  Pose2 truth;  ///< in the world; may be changed at any time, which wheels and gyro do not see
  Timestamp now{std::chrono::seconds(100)};
  std::mt19937 random;

 private:
  double noise(double sigma) { return sigma > 0.0 ? sigma * normal_(random) : 0.0; }

  struct {
    std::function<double(const Pose2&, double)> range;
  } walls_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  int steps_ = 0;
};

}  // namespace slam::test
