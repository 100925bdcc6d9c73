// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/intake/sensor_intake.hpp"

#include <algorithm>
#include <cmath>

#include "core/plausibility.hpp"

namespace slam {
namespace {

std::optional<Timestamp> newestOf(const ForwardJumpGuard& a, const ForwardJumpGuard& b) {
  return std::max(a.last(), b.last());  // none is before any
}

}  // namespace

SensorIntake::SensorIntake(const IntakeConfig& config, const LidarModel& lidar)
    : config_(config),
      wheels_(config.stamps, config.wheel_time_offset),
      lidar_(config.stamps, lidar.time_offset),
      imu_(config.stamps, config.imu_time_offset),
      T_base_lidar_(lidar.T_base_lidar),
      repeats_(config.repeats, lidar.upside_down ? -1.0 : 1.0) {}

std::optional<WheelSample> SensorIntake::accept(const WheelSample& sample) {
  if (!isPlausible(sample)) return ++implausible_, std::nullopt;
  if (!wheels_.guard.passes(sample.stamp, newestOf(imu_.guard, lidar_.guard))) return std::nullopt;
  WheelSample accepted = sample;
  accepted.stamp = wheels_.order.next(sample.stamp) + wheels_.offset;
  return accepted;
}

std::optional<ImuSample> SensorIntake::accept(const ImuSample& sample, Timestamp newest) {
  if (!isPlausible(sample)) return ++implausible_, std::nullopt;
  if (!imu_.guard.passes(sample.stamp, newestOf(wheels_.guard, lidar_.guard))) return std::nullopt;
  ImuSample accepted = sample;
  accepted.stamp = imu_.order.next(sample.stamp, newest) + imu_.offset;
  return accepted;
}

SensorIntake::Scan SensorIntake::accept(const LaserScan& scan, const EkfTimeline& pose, const EkfTimeline& odometry,
                                        std::span<const float> codes) {
  ++scans_;
  if (!lidar_.guard.passes(scan.stamp, newestOf(wheels_.guard, imu_.guard)))
    return {.first = pose.newestStamp(), .misdated = true};
  repeats_.add(scan, codes);
  if (isRepeat(scan)) {
    ++repeated_;
    return {last_first_ + std::max(Duration(0), scan.stamp - last_scan_)};
  }
  const std::uint32_t retimed = lidar_.order.retimed();
  const Timestamp first = lidar_.order.next(scan.stamp) + lidar_.offset;
  last_scan_ = scan.stamp;
  last_first_ = first;
  if (pose.started() && first < pose.oldestStamp()) {
    ++too_late_;
    return {first};
  }
  const bool stuck = isStuck(first, odometry);
  repeated_ += stuck;
  return {first, !stuck, lidar_.order.interval(), stuck, false, lidar_.order.retimed() > retimed};
}

/// Whether the scan was sent twice: a lidar needs its time for the next one.
bool SensorIntake::isRepeat(const LaserScan& scan) const {
  const double soonest = std::max(config_.fastest_turn, config_.soonest_scan * lidar_.order.interval());
  return repeats_.isRepeat() && toSeconds(scan.stamp - last_scan_) < soonest;
}

/// A lidar that repeats a turn would hold the robot in place, or take it back when it stops: its scans fit perfectly.
bool SensorIntake::isStuck(Timestamp first, const EkfTimeline& odometry) {
  if (odometry.upTo(first).standstill()) return repeats_.isStuck(std::nullopt);
  return repeats_.isStuck(odometry.poseAt(first) * T_base_lidar_);
}

void SensorIntake::addTo(FrontEndCounters& counters) const {
  counters.scans = scans_;
  counters.scans_repeated = repeated_;
  counters.scans_too_late = too_late_;
  counters.scans_retimed = lidar_.order.retimed();
  counters.clock_resets = lidar_.order.clockResets() + wheels_.order.clockResets();
  counters.implausible = implausible_;
  counters.far_ahead = wheels_.guard.held() + imu_.guard.held() + lidar_.guard.held();
}

}  // namespace slam
