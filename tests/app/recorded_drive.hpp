// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "matching/places.hpp"
#include "support/simulated/robot.hpp"

namespace slam::test {

/// What a robot with a depth camera records in a simulated place, with what may go wrong on the way.
class RecordedDrive : public SimulatedRobot {
 public:
  RecordedDrive(Place place, const Pose2& start, unsigned seed = 1)
      : SimulatedRobot(place, start, seed), place_(std::move(place)) {
    now = fromMicroseconds(1'700'000'000'000'000);
    wheels = {.scale = 1.01, .turn_scale = 0.98, .sigma = 0.00001, .turn_sigma = 0.00002};
    gyro = {.bias = 0.01, .sigma = 0.003};
    lidar.beams = 180;
    lidar.sweep = 0.2;
  }

  void run(double seconds, const Eigen::Vector3d& twist) {
    for (const Timestamp end = now + fromSeconds(seconds); now < end;) {
      step(twist, *this);
      if (++steps_ % 5 == 0 && has_depth) writeView();
    }
  }
  void add(const WheelSample& sample) { write(channel::kWheels, toMessage(sample, utime() + wheel_error), delay); }
  void add(const ImuSample& sample) { write(channel::kImu, toMessage(sample, utime() + imu_error), delay); }
  void add(LaserScan scan) {
    std::uniform_real_distribution<double> share(0.0, 1.0), range(0.3, 3.0);
    for (int i = 0; i < scan.size; ++i) {
      Beam& beam = scan.storage[static_cast<std::size_t>(i)];
      beam.intensity = 10.0F;
      if (share(random) < dazzled && beam.range > 0.0F) beam.range = static_cast<float>(range(random));
    }
    write(channel::kScan, toMessage(scan, toMicroseconds(scan.stamp) + lidar_error));
  }
  std::filesystem::path save(const std::filesystem::path& file) {
    std::stable_sort(events_.begin(), events_.end(),
                     [](const LogEvent& a, const LogEvent& b) { return a.utime < b.utime; });
    EventLogWriter log(file);
    for (const LogEvent& event : events_) log.write(event.utime, event.channel, event.data);
    return file;
  }

  bool has_depth = false;
  Pose2 T_base_camera;  ///< of the depth camera
  double delay = 0.0;   ///< [s] with which wheels' and gyro's messages arrive
  std::int64_t lidar_error = 0, wheel_error = 0, imu_error = 0, depth_error = 0;  ///< [us] of the stamps
  double dazzled = 0.0;  ///< [1] share of the beams that return noise

 private:
  std::int64_t utime() const { return toMicroseconds(now); }
  template <typename Message>
  void write(const char* channel, const Message& message, double late = 0.0) {
    std::vector<std::uint8_t> data(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(data.data(), 0, static_cast<int>(data.size()));
    events_.push_back({utime() + std::llround(1e6 * late), channel, std::move(data)});
  }
  void writeView() {
    constexpr double kReach = 4.0;  // [m]
    PseudoLaser view;
    view.bearing_min = -0.45F;
    view.bearing_step = 0.05F;
    view.size = 19;
    for (int i = 0; i < view.size; ++i) {
      const double range = place_.range(truth * T_base_camera, static_cast<double>(view.bearing(i)));
      view.storage[static_cast<std::size_t>(i)] = {range < kReach ? PseudoBeam::Kind::kHit : PseudoBeam::Kind::kFree,
                                                   static_cast<float>(std::min(range, kReach)), 0.5F};
    }
    write(channel::kDepth, toMessage(view, utime() + depth_error));
  }

  Place place_;
  int steps_ = 0;
  std::vector<LogEvent> events_;
};

}  // namespace slam::test
