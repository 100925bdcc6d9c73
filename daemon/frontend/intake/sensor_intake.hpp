// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <span>

#include "core/estimates.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "estimation/ekf_timeline.hpp"
#include "frontend/front_end_state.hpp"
#include "frontend/intake/stuck_scan_detector.hpp"
#include "frontend/lidar_model.hpp"
#include "timing/stamp_sequencer.hpp"

namespace slam {

/// Which samples are no measurement of now.
struct IntakeConfig {
  StampConfig stamps;
  ScanRepeatConfig repeats;
  double wheel_time_offset = 0.0, imu_time_offset = 0.0;  ///< [s] added to the stamps
  double fastest_turn = 0.02;                             ///< [s] no lidar turns faster ...
  double soonest_scan = 0.6;  ///< [1] ... nor in less than this share of the usual interval: a copy
};

/// Takes the sensors' samples in: puts their stamps in order and into the filters' time, and refuses those that are no
/// measurement of now: damaged stamps, copies, the turns that a stuck lidar repeats, and numbers that cannot be.
class SensorIntake {
 public:
  explicit SensorIntake(const IntakeConfig& config, const LidarModel& lidar = {});

  /// @return the sample with its stamp in the filters' time; nothing where it must not be used
  std::optional<WheelSample> accept(const WheelSample& sample);
  /// @param newest stamp of any stream so far
  std::optional<ImuSample> accept(const ImuSample& sample, Timestamp newest);

  struct Scan {
    Timestamp first;        ///< of the first beam, in the filters' time
    bool accepted = false;  ///< else it is left out
    double interval = 0.0;  ///< [s] usual time between two scans; 0: not known yet
    bool stuck = false;     ///< because the lidar repeats a turn although the robot moves
    bool misdated = false;  ///< because its stamp is far ahead of all others
    bool retimed = false;   ///< its stamp was no later than the last one: it is a guess
  };
  /// @param codes ranges that mean "no return" [m]
  Scan accept(const LaserScan& scan, const EkfTimeline& pose, const EkfTimeline& odometry,
              std::span<const float> codes = {});

  /// @param offset added to the lidar's stamps instead of the configured one
  void setLidarOffset(Duration offset) { lidar_.offset = offset; }

  void addTo(FrontEndCounters& counters) const;

 private:
  bool isRepeat(const LaserScan& scan) const;
  bool isStuck(Timestamp first, const EkfTimeline& odometry);

  /// How the stamps of a sensor become those of the filters.
  template <typename Order>
  struct Stream {
    Stream(const StampConfig& config, double seconds) : offset(fromSeconds(seconds)), guard(config), order(config) {}
    Duration offset;
    ForwardJumpGuard guard;
    Order order;
  };

  IntakeConfig config_;
  Stream<StampSequencer> wheels_, lidar_;
  Stream<ClockStepBridge> imu_;
  Pose2 T_base_lidar_;
  StuckScanDetector repeats_;
  Timestamp last_scan_, last_first_;  // as recorded, and in the filters' time
  std::uint32_t scans_ = 0, repeated_ = 0, too_late_ = 0, implausible_ = 0;
};

}  // namespace slam
