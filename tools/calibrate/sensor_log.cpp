// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/sensor_log.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/received.hpp"
#include "slam/pipeline.hpp"
#include "timing/stamp_sequencer.hpp"

namespace slam {
namespace {

/// The wheels' angles, recorded or taken back from the dead reckoning, stamped as the pipeline stamps them.
class WheelCollector {
 public:
  explicit WheelCollector(const DifferentialBase& base) : base_(base) {}

  void add(const wheels_t& message, const WheelSample& sample) {
    if (!guard_.passes(sample.stamp)) return;
    const Timestamp stamp = stamps_.next(sample.stamp);
    if (message.nwheels >= 2) recorded_.push_back({stamp, message.angles[0], message.angles[1]});

    AccumulatedAngles angles = reckoned_.empty() ? AccumulatedAngles{} : reckoned_.back();
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
  std::vector<AccumulatedAngles> recorded_, reckoned_;
};

class LogFeeder {
 public:
  explicit LogFeeder(const Config& config)
      : use_imu_(config.imu_device.driver != ImuDriver::kNone),
        pipeline_(withoutLoops(config)),
        wheels_(config.base_device.geometry) {}

  void feed(const LogEvent& event) {
    if (event.channel == channel::kScan) {
      if (const auto scan = take<scan_t>(event, scans_)) add(*scan.sample);
    } else if (event.channel == channel::kWheels) {
      if (const auto wheels = take<wheels_t>(event, wheels_seen_)) add(*wheels.message, *wheels.sample);
    } else if (event.channel == channel::kImu && use_imu_) {
      if (const auto imu = take<imu_t>(event, imus_)) add(*imu.sample);
    }
  }

  /// What was refused of scans and of wheels, and why; empty: none.
  std::string refusedScans() const { return scans_.words(); }
  std::string refusedWheels() const { return wheels_seen_.words(); }

  SensorLog finish() {
    wheels_.finish(log_);
    return std::move(log_);
  }

 private:
  /// Motions are measured between scans near in time: a loop that is closed would put a jump between them.
  static PipelineConfig withoutLoops(const Config& config) {
    PipelineConfig pipeline{config.front_end, backEndConfig(config), config.map, false};
    pipeline.back_end.localise_only = false;
    pipeline.back_end.close_loops = false;
    return pipeline;
  }

  template <typename Message>
  Received<Message> take(const LogEvent& event, RefusedMessages& refused) {
    Received<Message> received(event.data);
    refused.count(received.refusal);
    log_.rejected_messages += received.refusal != Refusal::kNone;
    return received;
  }

  void add(const wheels_t& message, const WheelSample& sample) {
    if (!sample.turn_rate_known) {
      throw std::runtime_error(
          "SLAM_WHEELS measures speed only (turn_rate_known is false), which does not show the track or one wheel; "
          "record a log with the angles of both wheels");
    }
    pipeline_.add(sample);
    wheels_.add(message, sample);
  }

  void add(const ImuSample& sample) {
    pipeline_.add(sample);
    const bool later = log_.turn_rates.empty() || sample.stamp > log_.turn_rates.back().stamp;
    if (sample.rate_known && later) log_.turn_rates.push_back({sample.stamp, sample.gyro.z()});
  }

  void add(const LaserScan& scan) {
    const ScanOutcome outcome = pipeline_.add(scan);
    ++log_.scans_read;
    if (outcome.fused && outcome.match.observable == 3) {
      log_.scans.push_back({outcome.stamp, outcome.match.T_ref_base, outcome.match.covariance});
    }
  }

  bool use_imu_;
  RefusedMessages scans_{channel::kScan}, wheels_seen_{channel::kWheels}, imus_{channel::kImu};
  Pipeline pipeline_;
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
  const auto require = [&file](bool there, const std::string& refused, const char* otherwise) {
    if (there) return;
    throw std::runtime_error(file.string() + ": " +
                             (refused.empty() ? otherwise : "nothing in it can be used: " + refused));
  };
  require(log.scans_read > 0, feeder.refusedScans(), "no SLAM_SCAN in it; record one with lidar");
  require(!log.wheels.empty(), feeder.refusedWheels(), "no SLAM_WHEELS in it; record one with wheels");
  log.skipped_bytes = reader.skippedBytes();
  log.truncated = reader.truncated();
  return log;
}

}  // namespace slam
