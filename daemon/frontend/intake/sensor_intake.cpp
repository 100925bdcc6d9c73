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

bool isMoving(const Twist2& twist, const IntakeConfig& config) {
  return std::hypot(twist.vx, twist.vy) > config.moving_speed || std::abs(twist.omega) > config.moving_turn;
}

SensorIntake::SensorIntake(const IntakeConfig& config, const LidarModel& lidar)
    : config_(config),
      wheel_offset_(fromSeconds(config.wheel_time_offset)),
      imu_offset_(fromSeconds(config.imu_time_offset)),
      lidar_offset_(fromSeconds(lidar.time_offset)),
      wheel_guard_(config.stamps),
      imu_guard_(config.stamps),
      scan_guard_(config.stamps),
      wheel_stamps_(config.stamps),
      scan_stamps_(config.stamps),
      imu_clock_(config.stamps),
      T_base_lidar_(lidar.T_base_lidar),
      repeats_(config.repeats, lidar.upside_down ? -1.0 : 1.0) {}

std::optional<WheelSample> SensorIntake::accept(const WheelSample& sample) {
  if (!isPlausible(sample)) return ++implausible_, std::nullopt;
  if (!wheel_guard_.passes(sample.stamp, newestOf(imu_guard_, scan_guard_))) return std::nullopt;
  WheelSample accepted = sample;
  accepted.stamp = wheel_stamps_.next(sample.stamp) + wheel_offset_;
  return accepted;
}

std::optional<ImuSample> SensorIntake::accept(const ImuSample& sample, Timestamp newest) {
  if (!isPlausible(sample)) return ++implausible_, std::nullopt;
  if (!imu_guard_.passes(sample.stamp, newestOf(wheel_guard_, scan_guard_))) return std::nullopt;
  ImuSample accepted = sample;
  accepted.stamp = imu_clock_.next(sample.stamp, newest) + imu_offset_;
  return accepted;
}

SensorIntake::Scan SensorIntake::accept(const LaserScan& scan, const EkfTimeline& pose, const EkfTimeline& odometry,
                                        std::span<const float> codes) {
  ++scans_;
  if (!scan_guard_.passes(scan.stamp, newestOf(wheel_guard_, imu_guard_)))
    return {.first = pose.newestStamp(), .misdated = true};
  repeats_.add(scan, codes);
  if (isRepeat(scan)) {
    ++repeated_;
    return {last_first_ + std::max(Duration(0), scan.stamp - last_scan_)};
  }
  const std::uint32_t retimed = scan_stamps_.retimed();
  const Timestamp first = scan_stamps_.next(scan.stamp) + lidar_offset_;
  last_scan_ = scan.stamp;
  last_first_ = first;
  if (pose.started() && first < pose.oldestStamp()) {
    ++too_late_;
    return {first};
  }
  const bool stuck = isStuck(first, odometry);
  repeated_ += stuck;
  return {first, !stuck, scan_stamps_.interval(), stuck, false, scan_stamps_.retimed() > retimed};
}

/// Whether the scan was sent twice: a lidar needs its time for the next one.
bool SensorIntake::isRepeat(const LaserScan& scan) const {
  const double soonest = std::max(config_.fastest_turn, config_.soonest_scan * scan_stamps_.interval());
  return repeats_.isRepeat() && toSeconds(scan.stamp - last_scan_) < soonest;
}

/// A lidar that repeats a turn would hold the robot in place, or take it back when it stops: its scans fit perfectly.
bool SensorIntake::isStuck(Timestamp first, const EkfTimeline& odometry) {
  if (!isMoving(odometry.upTo(first).twist(), config_)) return repeats_.isStuck(std::nullopt);
  return repeats_.isStuck(odometry.poseAt(first) * T_base_lidar_);
}

void SensorIntake::addTo(FrontEndCounters& counters) const {
  counters.scans = scans_;
  counters.scans_repeated = repeated_;
  counters.scans_too_late = too_late_;
  counters.scans_retimed = scan_stamps_.retimed();
  counters.clock_resets = scan_stamps_.clockResets() + wheel_stamps_.clockResets();
  counters.implausible = implausible_;
  counters.far_ahead = wheel_guard_.held() + imu_guard_.held() + scan_guard_.held();
}

}  // namespace slam
