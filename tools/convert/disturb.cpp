// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/messages.hpp"
#include "core/pose_history.hpp"
#include "tools/convert/formats.hpp"

namespace slam {
namespace {

/// Turns the wheels' recorded dead reckoning into the disturbed one, increment by increment.
class WheelDisturbance {
 public:
  WheelDisturbance(const Disturbance& disturbance, std::int64_t first, std::int64_t last)
      : disturbance_(disturbance), random_(disturbance.seed) {
    std::uniform_real_distribution<double> when(static_cast<double>(first), static_cast<double>(last));
    for (int i = 0; i < disturbance.jumps; ++i) jumps_.push_back(static_cast<std::int64_t>(when(random_)));
    std::sort(jumps_.begin(), jumps_.end());
  }

  WheelSample apply(WheelSample recorded, std::int64_t utime) {
    history_.push(recorded.stamp, recorded.T_wheels_base);
    recorded.T_wheels_base = history_.at(recorded.stamp - fromSeconds(disturbance_.wheel_lag), std::chrono::hours(1))
                                 .value_or(recorded.T_wheels_base);
    Pose2 motion = last_ ? between(*last_, recorded.T_wheels_base) : Pose2{};
    last_ = recorded.T_wheels_base;
    const double distance = std::hypot(motion.x, motion.y), turn = std::abs(motion.theta);
    if (disturbance_.reverse_sign && motion.x < 0.0) motion.x = -motion.x;
    motion.x *= 1.0 + disturbance_.distance_scale;
    motion.x += disturbance_.noise * std::sqrt(distance) * normal_(random_);
    motion.theta += disturbance_.noise * std::sqrt(distance + turn) * normal_(random_);
    for (; next_jump_ < jumps_.size() && utime >= jumps_[next_jump_]; ++next_jump_) {
      motion = motion * Pose2{disturbance_.jump_translation * uniform_(random_),
                              disturbance_.jump_translation * uniform_(random_),
                              disturbance_.jump_rotation * uniform_(random_)};
    }
    pose_ = pose_ * motion;
    WheelSample disturbed = recorded;
    disturbed.T_wheels_base = pose_;
    return disturbed;
  }

 private:
  const Disturbance& disturbance_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
  std::vector<std::int64_t> jumps_;
  std::size_t next_jump_ = 0;
  PoseHistory history_{4096};
  std::optional<Pose2> last_;
  Pose2 pose_;
};

std::pair<std::int64_t, std::int64_t> timeSpan(const std::filesystem::path& log) {
  EventLogReader reader(log);
  std::int64_t first = 0, last = 0;
  for (LogEvent event; reader.next(event); last = event.utime) {
    if (first == 0) first = event.utime;
  }
  return {first, last};
}

}  // namespace

ConvertReport disturbLog(const std::filesystem::path& in, const std::filesystem::path& out,
                         const Disturbance& disturbance) {
  const auto [first, last] = timeSpan(in);
  WheelDisturbance wheels(disturbance, first, last);
  EventLogReader reader(in);
  ConvertReport report;
  LogOutput log;
  for (LogEvent event; reader.next(event);) {
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      const auto scan = message ? fromMessage(*message) : std::nullopt;
      if (scan) {
        log.add(event.utime, *scan, message->utime);
        ++report.scans;
      } else {
        report.reject(in.filename().string(), "a SLAM_SCAN message that does not decode");
      }
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      if (!sample) {
        report.reject(in.filename().string(), "a SLAM_WHEELS message that does not decode");
        continue;
      }
      log.add(event.utime, wheels.apply(*sample, message->utime), message->utime);
      ++report.wheels;
    } else if (event.channel == channel::kImu) {
      const auto message = decodeChecked<imu_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      if (sample) {
        log.add(event.utime, *sample, message->utime);
        ++report.imu;
      } else {
        report.reject(in.filename().string(), "a SLAM_IMU message that does not decode");
      }
    }
  }
  log.write(out);
  return report;
}

}  // namespace slam
