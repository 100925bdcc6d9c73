// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <memory>
#include <optional>

#include "diagnostics/motion_probe.hpp"
#include "frontend/front_end.hpp"
#include "mapping/mapper.hpp"
#include "mapping/occupancy_grid.hpp"
#include "slam/map_builder.hpp"

namespace slam {

struct PipelineConfig {
  FrontEndConfig front_end;
  BackEndConfig back_end;
  OccupancyGridConfig map;
  bool draws = true;  ///< false: the poses alone are wanted
};

/// The settings for a map: a floor plan is coarser than scans.
PipelineConfig fitted(PipelineConfig config, const MapState& map);

/// The whole of slamd in one thread: front end, MapBuilder, Mapper and the check of the sensors. The daemon runs the
/// same parts in threads of their own, with queues between them.
///
/// No thread, clock or I/O. Not safe for concurrent use.
class Pipeline {
 public:
  /// @param config any, which is fitted() here
  /// @param map to begin in; without keyframes: an unknown place
  explicit Pipeline(const PipelineConfig& config, const MapState& map = MapState(), Stopwatch stopwatch = nullptr);

  void add(const WheelSample& sample);
  void add(const ImuSample& sample);
  void add(const PseudoLaser& laser);
  /// match(), build() and correct(), one after the other.
  ScanOutcome add(const LaserScan& scan);

  /// The steps of add(scan), for those who let time pass between them, as the daemon's threads do.
  ScanOutcome match(const LaserScan& scan);
  void build(const Keyframe& keyframe);
  void correct();
  /// Made and not applied yet.
  const MapCorrection* correction() const { return correction_.get(); }

  void setPose(const Pose2& T_map_base, const Eigen::Vector3d& sigma) { front_end_->setPose(T_map_base, sigma); }

  /// Called with each scan's outcome, before it changes the map.
  std::function<void(const ScanOutcome&)> on_scan = {};
  /// Called with each keyframe's update, before the correction that it holds is applied.
  std::function<void(const MapUpdate&)> on_update = {};

  /// All that is needed to go on another day, but for the hour. @pre draws
  MapState state();
  const FrontEnd& frontEnd() const { return *front_end_; }
  const BackEnd& backEnd() const { return builder_.backEnd(); }
  SensorFindings findings() const { return findingsOf(probe_, *front_end_); }
  /// With all drawn that is left to draw anew. @pre draws
  Mapper& drawn();
  /// @pre draws
  const Mapper& mapper() const { return *mapper_; }

 private:
  std::unique_ptr<FrontEnd> front_end_;  // large
  MotionProbe probe_;
  MapBuilder builder_;
  std::optional<Mapper> mapper_;
  std::unique_ptr<MapCorrection> correction_;
};

}  // namespace slam
