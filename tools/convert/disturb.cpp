// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/messages.hpp"
#include "core/pose_history.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"

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
    if (disturbance_.wheel_lag > 0.0) {
      history_.push(recorded.stamp, recorded.T_wheels_base);
      recorded.T_wheels_base = history_.at(recorded.stamp - fromSeconds(disturbance_.wheel_lag), std::chrono::hours(1))
                                   .value_or(recorded.T_wheels_base);
    }
    Pose2 motion = last_ ? between(*last_, recorded.T_wheels_base) : Pose2{};
    last_ = recorded.T_wheels_base;
    const double distance = std::hypot(motion.x, motion.y), turn = std::abs(motion.theta);
    if (disturbance_.wheels_swapped) motion = {motion.x, -motion.y, -motion.theta};
    if (disturbance_.wheels_backwards) motion = {-motion.x, -motion.y, -motion.theta};
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

/// What the lidar's mounting does to a scan.
void mount(LaserScan& scan, const Disturbance& disturbance) {
  for (int i = 0; i < scan.size; ++i) {
    float& bearing = scan.storage[static_cast<std::size_t>(i)].bearing;
    if (disturbance.lidar_upside_down) bearing = -bearing;
    if (disturbance.lidar_turned) bearing = static_cast<float>(wrapAngle(bearing + std::numbers::pi));
  }
}

std::pair<std::int64_t, std::int64_t> timeSpan(const std::filesystem::path& log) {
  EventLogReader reader(log);
  std::int64_t first = 0, last = 0;
  for (LogEvent event; reader.next(event); last = event.utime) {
    if (first == 0) first = event.utime;
  }
  return {first, last};
}

}  // namespace

Recording disturbLog(const std::filesystem::path& in, const std::filesystem::path& out,
                     const Disturbance& disturbance) {
  const auto [first, last] = timeSpan(in);
  WheelDisturbance wheels(disturbance, first, last);
  const std::int64_t middle = first + (last - first) / 2;
  EventLogReader reader(in);
  Recording report;
  LogOutput log;
  for (LogEvent event; reader.next(event);) {
    const std::int64_t set_back = disturbance.time_backwards && event.utime > middle ? 30'000'000 : 0;
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      auto scan = message ? fromMessage(*message) : std::nullopt;
      if (!scan) {
        report.reject(in.filename().string(), "a SLAM_SCAN message that does not decode");
        continue;
      }
      mount(*scan, disturbance);
      const bool late = disturbance.time_backwards && report.scans % 10 == 9;
      for (int copy = 0; copy < (disturbance.double_scans ? 2 : 1); ++copy) {
        log.add(event.utime, *scan, message->utime - set_back - (late ? 300'000 : 0));
        ++report.scans;
      }
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      if (!sample) {
        report.reject(in.filename().string(), "a SLAM_WHEELS message that does not decode");
        continue;
      }
      log.add(event.utime, wheels.apply(*sample, message->utime), message->utime - set_back);
      ++report.wheels;
    } else if (event.channel == channel::kImu) {
      const auto message = decodeChecked<imu_t>(event.data);
      auto sample = message ? fromMessage(*message) : std::nullopt;
      if (!sample) {
        report.reject(in.filename().string(), "a SLAM_IMU message that does not decode");
        continue;
      }
      if (disturbance.gyro_reversed) sample->gyro.z() = -sample->gyro.z();
      log.add(event.utime, *sample, message->utime - set_back);
      ++report.imu;
    }
  }
  log.write(out);
  return report;
}

}  // namespace slam
