// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "matching/places.hpp"

namespace slam::test {

/// What a robot records in a simulated place, in virtual time, with what may go wrong on the way.
class RecordedDrive {
 public:
  static constexpr int kBeams = 180;
  static constexpr double kStep = 0.02, kScanPeriod = 0.2, kImageReach = 4.0;  // [s], [s], [m]

  RecordedDrive(Place place, const Pose2& start, unsigned seed = 1)
      : pose(start), place_(std::move(place)), random_(seed) {}

  void run(double seconds, const Eigen::Vector3d& twist) {
    for (const double end = now_ + seconds; now_ < end - 0.5 * kStep;) {
      pose = pose * exp(kStep * twist);
      now_ += kStep;
      wheels_ = wheels_ * exp(kStep * Eigen::Vector3d(wheel_scale * twist.x() + spin, 0.0, 0.98 * twist.z()));
      if (has_wheels) {
        wheels_ = wheels_ * Pose2{0.00001 * noise(), 0.0, 0.00002 * noise()};
        write(channel::kWheels, toMessage(WheelSample{.stamp = {}, .T_wheels_base = wheels_}, utime() + wheel_error));
      }
      if (has_gyro) {
        const ImuSample imu{{}, {0.0, 0.0, twist.z() + 0.01 + 0.003 * noise()}, {0.0, 0.0, 9.81}};
        write(channel::kImu, toMessage(imu, utime() + imu_error));
      }
      ++step_;
      if (has_lidar && step_ % 10 == 0) writeScan(twist);
      if (has_depth && step_ % 5 == 0) writeView();
    }
  }
  /// The wheels' next sample claims a leap that no robot makes. @param metres, radians of it
  void leap(double metres, double radians) { wheels_ = wheels_ * Pose2{metres, 0.0, radians}; }
  std::filesystem::path save(const std::filesystem::path& file) {
    std::stable_sort(events_.begin(), events_.end(),
                     [](const LogEvent& a, const LogEvent& b) { return a.utime < b.utime; });
    EventLogWriter log(file);
    for (const LogEvent& event : events_) log.write(event.utime, event.channel, event.data);
    return file;
  }

  Pose2 pose;           ///< in the world; may be changed at any time, which wheels and gyro do not see
  Pose2 T_base_camera;  ///< of the depth camera
  bool has_wheels = true, has_gyro = true, has_lidar = true, has_depth = false;
  double wheel_scale = 1.01, spin = 0.0;  ///< [1] of the way, [m/s] of wheels that spin
  double delay = 0.0;                     ///< [s] with which wheels' and gyro's messages arrive
  std::int64_t lidar_error = 0, wheel_error = 0, imu_error = 0, depth_error = 0;  ///< [us] of the stamps
  double dazzled = 0.0;  ///< [1] share of the beams that return noise

 private:
  double noise() { return normal_(random_); }
  std::int64_t utime() const { return 1'700'000'000'000'000 + std::llround(1e6 * now_); }
  template <typename Message>
  void write(const char* channel, const Message& message) {
    const bool late = channel != channel::kScan && channel != channel::kDepth;
    std::vector<std::uint8_t> data(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(data.data(), 0, static_cast<int>(data.size()));
    events_.push_back({utime() + (late ? std::llround(1e6 * delay) : 0), channel, std::move(data)});
  }
  std::optional<double> range(const Pose2& from, double bearing, double reach) const {
    const double direction = from.theta + bearing;
    return place_.world.castRay({from.x, from.y, 0.2}, {std::cos(direction), std::sin(direction), 0.0}, reach);
  }
  /// A turn of the lidar that ends now, each beam from where the robot was then.
  void writeScan(const Eigen::Vector3d& twist) {
    LaserScan scan;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(place_.reach);
    for (int i = 0; i < kBeams; ++i) {
      const double offset = kScanPeriod * i / kBeams, bearing = wrapAngle(2.0 * std::numbers::pi * i / kBeams);
      const auto seen = range(pose * exp((offset - kScanPeriod) * twist), bearing, place_.reach);
      const bool wrong = std::uniform_real_distribution<double>(0.0, 1.0)(random_) < dazzled;
      const double value = wrong ? std::uniform_real_distribution<double>(0.3, 3.0)(random_) : seen.value_or(0.0);
      scan.push({.range = seen ? static_cast<float>(value + 0.01 * noise()) : 0.0F,
                 .bearing = static_cast<float>(bearing),
                 .time_offset = static_cast<float>(offset),
                 .intensity = 10.0F});
    }
    write(channel::kScan, toMessage(scan, utime() - std::llround(1e6 * kScanPeriod) + lidar_error));
  }
  void writeView() {
    PseudoLaser view;
    view.bearing_min = -0.45F;
    view.bearing_step = 0.05F;
    view.size = 19;
    for (int i = 0; i < view.size; ++i) {
      const auto seen = range(pose * T_base_camera, static_cast<double>(view.bearing(i)), kImageReach);
      view.storage[static_cast<std::size_t>(i)] = {seen ? PseudoBeam::Kind::kHit : PseudoBeam::Kind::kFree,
                                                   static_cast<float>(seen.value_or(kImageReach)), 0.5F};
    }
    write(channel::kDepth, toMessage(view, utime() + depth_error));
  }

  Place place_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  Pose2 wheels_;
  double now_ = 0.0;
  int step_ = 0;
  std::vector<LogEvent> events_;
};

}  // namespace slam::test
