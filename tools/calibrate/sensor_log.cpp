// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/sensor_log.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "slam/localizer.hpp"
#include "slam/stamp_sequencer.hpp"

namespace slam {
namespace {

/// The wheels' angles, recorded or taken back from the dead reckoning, stamped as the Localizer stamps them.
class WheelCollector {
 public:
  explicit WheelCollector(const DifferentialBase& base) : base_(base) {}

  void add(const wheels_t& message, const WheelSample& sample) {
    if (!guard_.passes(sample.stamp)) return;
    const Timestamp stamp = stamps_.next(sample.stamp);
    if (message.nwheels >= 2) recorded_.push_back({stamp, message.angles[0], message.angles[1]});

    WheelAngles angles = reckoned_.empty() ? WheelAngles{} : reckoned_.back();
    if (last_) {
      const Eigen::Vector3d xi = log(between(*last_, sample.T_wheels_base));
      angles.left += (xi.x() - base_.half_track * xi.z()) / base_.wheel_radius;
      angles.right += (xi.x() + base_.half_track * xi.z()) / base_.wheel_radius;
    }
    angles.stamp = stamp;
    reckoned_.push_back(angles);
    last_ = sample.T_wheels_base;
  }

  void finish(SensorLog& log) {
    log.angles_recorded = !recorded_.empty() && recorded_.size() == reckoned_.size();
    log.wheels = std::move(log.angles_recorded ? recorded_ : reckoned_);
  }

 private:
  DifferentialBase base_;
  ForwardJumpGuard guard_;
  StampSequencer stamps_;
  std::optional<Pose2> last_;
  std::vector<WheelAngles> recorded_, reckoned_;
};

class LogFeeder {
 public:
  explicit LogFeeder(const Config& config)
      : use_imu_(config.imu_device.driver != "none"),
        localizer_(config.localizer),
        wheels_(config.base_device.geometry) {}

  void feed(const LogEvent& event) {
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      const auto scan = message ? fromMessage(*message) : std::nullopt;
      scan ? add(*scan) : reject();
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      sample ? add(*message, *sample) : reject();
    } else if (event.channel == channel::kImu && use_imu_) {
      const auto message = decodeChecked<imu_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      sample ? localizer_.add(*sample) : reject();
    }
  }

  SensorLog finish() {
    wheels_.finish(log_);
    return std::move(log_);
  }

 private:
  void reject() { ++log_.rejected_messages; }

  void add(const wheels_t& message, const WheelSample& sample) {
    if (!sample.turn_rate_known) {
      throw std::runtime_error(
          "SLAM_WHEELS measures speed only (turn_rate_known is false), which does not show the track or one wheel; "
          "record a log with the angles of both wheels");
    }
    localizer_.add(sample);
    wheels_.add(message, sample);
  }

  void add(const LaserScan& scan) {
    const ScanOutcome outcome = localizer_.add(scan);
    ++log_.scans_read;
    if (outcome.fused && outcome.match.observable == 3) {
      log_.scans.push_back({outcome.stamp, outcome.match.T_ref_base, outcome.match.covariance});
    }
  }

  bool use_imu_;
  Localizer localizer_;
  WheelCollector wheels_;
  SensorLog log_;
};

}  // namespace

SensorLog readSensorLog(const Config& config, const std::filesystem::path& file,
                        const std::function<void(double log_seconds)>& progress) {
  EventLogReader reader(file);
  LogFeeder feeder(config);
  std::int64_t first = 0;
  try {
    for (LogEvent event; reader.next(event);) {
      if (first == 0) first = event.utime;
      feeder.feed(event);
      if (progress) progress(1e-6 * static_cast<double>(event.utime - first));
    }
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
  SensorLog log = feeder.finish();
  if (log.scans_read == 0) throw std::runtime_error(file.string() + ": no SLAM_SCAN in it; record one with lidar");
  if (log.wheels.empty()) throw std::runtime_error(file.string() + ": no SLAM_WHEELS in it; record one with wheels");
  log.skipped_bytes = reader.skippedBytes();
  log.truncated = reader.truncated();
  return log;
}

}  // namespace slam
