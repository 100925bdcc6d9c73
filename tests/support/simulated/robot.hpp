// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <deque>
#include <functional>
#include <numbers>
#include <random>

#include "matching/places.hpp"
#include "slam/pipeline.hpp"

namespace slam::test {

/// A robot with wheels, gyro and lidar in a simulated place, and the whole pipeline, in virtual time.
class Robot {
 public:
  static constexpr int kBeams = 360;

  /// @param map to begin in; empty: an unknown place
  explicit Robot(const Place& place, const Pose2& start, bool localise_only = false, const MapState& map = MapState(),
                 const BackEndConfig& back_end = {})
      : truth(start), place_(place), pipeline(settings(localise_only, back_end), map) {}

  void run(double seconds, const Eigen::Vector3d& twist) {
    for (const Timestamp end = now + fromSeconds(seconds); now < end;) {
      now += std::chrono::milliseconds(20);
      truth = truth * exp(0.02 * twist);
      wheels_ = wheels_ * exp(0.02 * Eigen::Vector3d(wheel_scale * twist.x(), 0.0, 0.99 * twist.z()));
      if (has_wheels) pipeline.add(WheelSample{now, wheels_});
      const ImuSample imu{now, {0, 0, twist.z() + 0.01 + 0.001 * noise_(random_)}, {0, 0, 9.81}};
      if (has_imu) pipeline.add(imu);
      if (++step_ % 10 != 0) continue;  // 5 Hz
      take(scan());
      if (after_scan) after_scan();
    }
  }
  void drive(double metres) { run(metres / 0.4, {0.4, 0.0, 0.0}); }
  void turn(double radians) { run(std::abs(radians) / 0.8, {0.0, 0.0, std::copysign(0.8, radians)}); }

  PoseEstimate estimate() const { return pipeline.frontEnd().estimate(now); }
  LocalisationState state() const { return estimate().state; }
  /// Of the pose in map, which begins at T_world_map [m].
  double error(const Pose2& T_world_map) const {
    return (estimate().T_map_base.translation() - between(T_world_map, truth).translation()).norm();
  }
  Pose2 truth;  ///< in the world; may be changed at any time, which wheels and gyro do not see
  Timestamp now{std::chrono::seconds(100)};
  std::function<void()> after_scan;
  /// Asked after each scan, true: the oldest keyframe is not taken yet, or the correction not applied yet, as happens
  /// where the back end has a thread of its own. Empty: all is done at once.
  std::function<bool()> keyframe_waits, correction_waits;
  std::deque<Keyframe> keyframes;  ///< which the back end has not taken yet
  bool has_wheels = true, has_imu = true;
  double wheel_scale = 1.01;             ///< [1] what the wheels tell of the way
  double view = 2.0 * std::numbers::pi;  ///< [rad] of the lidar, to both sides of ahead

 private:
  static PipelineConfig settings(bool localise_only, const BackEndConfig& back_end) {
    PipelineConfig config;
    config.back_end = back_end;
    config.front_end.lidar.range_sigma = config.back_end.match.range_sigma = 0.01;
    config.front_end.localise_only = config.back_end.localise_only = localise_only;
    return config;
  }
  LaserScan scan() {
    LaserScan scan;
    scan.stamp = now;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(place_.reach);
    for (int i = 0; i < kBeams; ++i) {
      const double bearing = wrapAngle(view * i / kBeams - 0.5 * view), direction = truth.theta + bearing;
      const auto range =
          place_.world.castRay({truth.x, truth.y, 0.2}, {std::cos(direction), std::sin(direction), 0.0}, place_.reach);
      scan.push({.range = range ? static_cast<float>(*range + 0.01 * noise_(random_)) : 0.0F,
                 .bearing = static_cast<float>(bearing)});
    }
    return scan;
  }
  void take(const LaserScan& scan) {
    const ScanOutcome outcome = pipeline.match(scan);
    if (outcome.keyframe != nullptr) keyframes.push_back(*outcome.keyframe);
    for (; !keyframes.empty() && !(keyframe_waits && keyframe_waits()); keyframes.pop_front()) {
      pipeline.build(keyframes.front());
    }
    if (pipeline.correction() != nullptr && !(correction_waits && correction_waits())) pipeline.correct();
  }

  Place place_;
  Pose2 wheels_;
  std::mt19937 random_{3};
  std::normal_distribution<double> noise_{0.0, 1.0};
  int step_ = 0;

 public:
  Pipeline pipeline;
};

}  // namespace slam::test
