// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <deque>
#include <functional>

#include "matching/places.hpp"
#include "slam/pipeline.hpp"
#include "support/simulated/robot.hpp"

namespace slam::test {

/// A robot with wheels, gyro and lidar in a simulated place, and the whole pipeline.
class Robot : public SimulatedRobot {
 public:
  /// @param map to begin in; empty: an unknown place
  explicit Robot(const Place& place, const Pose2& start, bool localise_only = false, const MapState& map = MapState(),
                 const BackEndConfig& back_end = {})
      : SimulatedRobot(place, start, 3), pipeline(settings(localise_only, back_end), map) {
    wheels = {.scale = 1.01, .turn_scale = 0.99};
    gyro = {.bias = 0.01, .sigma = 0.001};
    look(lidar.view);
  }

  void run(double seconds, const Eigen::Vector3d& twist) { SimulatedRobot::run(seconds, twist, *this); }
  void drive(double metres) { run(metres / 0.4, {0.4, 0.0, 0.0}); }
  void turn(double radians) { run(std::abs(radians) / 0.8, {0.0, 0.0, std::copysign(0.8, radians)}); }
  /// The lidar sees this much to both sides of ahead. @param view [rad]
  void look(double view) {
    lidar.view = view;
    lidar.first = -0.5 * view;
  }

  void add(const WheelSample& sample) { pipeline.add(sample); }
  void add(const ImuSample& sample) { pipeline.add(sample); }
  void add(const LaserScan& scan) {
    const ScanOutcome outcome = pipeline.match(scan);
    if (outcome.keyframe != nullptr) keyframes.push_back(*outcome.keyframe);
    for (; !keyframes.empty() && !(keyframe_waits && keyframe_waits()); keyframes.pop_front()) {
      pipeline.build(keyframes.front());
    }
    if (pipeline.correction() != nullptr && !(correction_waits && correction_waits())) pipeline.correct();
    if (after_scan) after_scan();
  }

  PoseEstimate estimate() const { return pipeline.frontEnd().estimate(now); }
  LocalisationState state() const { return estimate().state; }
  /// Of the pose in map, which begins at T_world_map [m].
  double error(const Pose2& T_world_map) const {
    return (estimate().T_map_base.translation() - between(T_world_map, truth).translation()).norm();
  }
  std::function<void()> after_scan;
  /// Asked after each scan, true: the oldest keyframe is not taken yet, or the correction not applied yet, as happens
  /// where the back end has a thread of its own. Empty: all is done at once.
  std::function<bool()> keyframe_waits, correction_waits;
  std::deque<Keyframe> keyframes;  ///< which the back end has not taken yet
  Pipeline pipeline;

 private:
  static PipelineConfig settings(bool localise_only, const BackEndConfig& back_end) {
    PipelineConfig config;
    config.back_end = back_end;
    config.front_end.lidar.range_sigma = config.back_end.match.range_sigma = 0.01;
    config.front_end.localise_only = config.back_end.localise_only = localise_only;
    return config;
  }
};

}  // namespace slam::test
