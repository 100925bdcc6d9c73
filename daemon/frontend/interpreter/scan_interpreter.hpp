// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <span>

#include "core/scan.hpp"
#include "estimation/ekf_timeline.hpp"
#include "frontend/interpreter/body_watch.hpp"
#include "frontend/interpreter/cabin_watch.hpp"
#include "frontend/interpreter/no_return_watch.hpp"
#include "frontend/interpreter/range_noise_watch.hpp"
#include "frontend/interpreter/sweep_watch.hpp"
#include "frontend/lidar_model.hpp"

namespace slam {

/// How it is found out which beams say nothing, or when they were measured.
struct InterpreterConfig {
  BodyWatchConfig body;
  NoReturnConfig no_return;
  RangeNoiseConfig range_noise;
  SweepWatchConfig sweep;
  CabinWatchConfig cabin;
  bool several_floors = false;  ///< there are maps of other floors, to which a lift may take the robot
};

/// Decides what a scan's beams mean before they are matched. A beam that says nothing about the world becomes one
/// without return, which matches nothing, is drawn nowhere and frees no space. Beams that a turning head measured get
/// their times.
///
/// No thread, clock or I/O; after construction no allocation.
class ScanInterpreter {
 public:
  /// @param body what moves with the robot, as last known
  ScanInterpreter(const InterpreterConfig& config, const LidarModel& lidar, const BodyShape& body = {});

  /// @param first    stamp of the first beam in the filters' time
  /// @param interval [s] usual time between two scans; 0: not known yet
  /// @param odometry how the robot moves, by wheels and gyro alone
  /// @return         valid until the next call
  const LaserScan& interpret(const LaserScan& recorded, Timestamp first, double interval, const EkfTimeline& odometry);

  /// By beam of the newest scan: it looked, and nothing came back from within the limits.
  std::span<const bool> open() const { return std::span(open_).first(static_cast<std::size_t>(scan_.size)); }
  const BodyShape& body() const { return body_.shape(); }
  /// What moves with the robot as far as the newest scan's beams are left out for it.
  const BodyShape& leftOut() const { return body_.leftOut(); }
  std::span<const float> noReturnCodes() const { return codes_.codes(); }
  const RangeNoiseWatch& rangeNoise() const { return noise_; }
  const CabinWatch& cabin() const { return cabin_; }
  /// The beams carry no times though the lidar measures them one after the other.
  bool timesMissing() const { return sweep_.order() != SweepWatch::Order::kAtOnce; }

 private:
  void giveTimes(Timestamp first, double interval, const EkfTimeline& odometry);
  bool isMasked(const Beam& beam) const;

  LidarModel lidar_;
  SweepWatch sweep_;
  NoReturnWatch codes_;
  BodyWatch body_;
  RangeNoiseWatch noise_;
  CabinWatch cabin_;
  bool several_floors_;
  LaserScan scan_;
  std::array<bool, LaserScan::kCapacity> open_{};
};

}  // namespace slam
