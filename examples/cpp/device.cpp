// SPDX-License-Identifier: BSD-3-Clause
// A device of your own for slamd: sends scans, wheels and a gyro by LCM, each with its own stamps.
//
// The readings come from a simulated robot that drives a circle in an L-shaped room; put your device's in their place.
// slamd runs beside it with lidar.driver, base.driver and imu.driver = "lcm". Usage: device [SECONDS]
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <slam/imu_t.hpp>
#include <slam/scan_t.hpp>
#include <slam/wheels_t.hpp>
#include <thread>

namespace {

using Clock = std::chrono::system_clock;  // slamd's stamps are UTC
using Seconds = std::chrono::duration<double>;

constexpr double kPi = 3.14159265358979323846;
constexpr double kSpeed = 0.3, kTurnRate = 0.3;  // [m/s], [rad/s]
constexpr double kTick = 0.02;                   // [s] of wheels and gyro
constexpr double kScanTime = 0.1;                // [s] of a turn of the lidar
constexpr int kBeams = 360, kBeamsOfTick = 72;

struct Pose {
  double x, y, theta;  // [m], [m], [rad]
};

/// Corners of the room [m]; the robot starts at (0, 0) and looks along x.
constexpr double kRoom[][2] = {{-2.5, -1.0}, {3.0, -1.0}, {3.0, 3.5}, {0.8, 3.5}, {0.8, 2.7}, {-2.5, 2.7}};
constexpr std::size_t kCorners = sizeof kRoom / sizeof kRoom[0];

/// Where the robot is t seconds after the start.
Pose poseAt(double t) {
  const double theta = kTurnRate * t, radius = kSpeed / kTurnRate;
  return {radius * std::sin(theta), radius * (1.0 - std::cos(theta)), theta};
}

/// From a place to the nearest wall in a direction [m].
double rangeFrom(const Pose& at, double angle) {
  const double dx = std::cos(angle), dy = std::sin(angle);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kCorners; ++i) {
    const auto& a = kRoom[i];
    const auto& b = kRoom[(i + 1) % kCorners];
    const double ex = b[0] - a[0], ey = b[1] - a[1], across = dx * ey - dy * ex;
    if (std::abs(across) < 1e-9) continue;  // parallel
    const double along = ((a[0] - at.x) * ey - (a[1] - at.y) * ex) / across;
    const double share = ((a[0] - at.x) * dy - (a[1] - at.y) * dx) / across;
    if (along > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, along);
  }
  return nearest;
}

std::int64_t toMicroseconds(Clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : std::numeric_limits<double>::infinity();
  lcm::LCM lcm;  // LCM_DEFAULT_URL, or this computer alone
  if (!lcm.good()) {
    std::fprintf(stderr, "LCM cannot open its socket: is there a multicast route (ip route add 224.0.0.0/4 dev lo)?\n");
    return 1;
  }
  const Clock::time_point start = Clock::now();
  const auto timeOf = [&](double t) { return start + std::chrono::duration_cast<Clock::duration>(Seconds(t)); };
  slam::scan_t scan{};
  double t = 0.0, turn_began = 0.0;
  while (t < seconds) {
    std::this_thread::sleep_until(timeOf(t + kTick));
    // The lidar has turned on since the last tick; each beam starts where the robot was at its own time.
    for (int i = 0; i < kBeamsOfTick; ++i) {
      const auto beam = static_cast<double>(scan.ranges.size());
      const double offset = kScanTime * beam / kBeams, bearing = 2.0 * kPi * beam / kBeams - kPi;
      const Pose at = poseAt(turn_began + offset);
      scan.ranges.push_back(static_cast<float>(rangeFrom(at, at.theta + bearing)));
      scan.bearings.push_back(static_cast<float>(bearing));
      scan.time_offsets.push_back(static_cast<float>(offset));
      scan.intensities.push_back(0.0F);
    }
    t += kTick;
    const Pose pose = poseAt(t);
    slam::wheels_t wheels{};
    wheels.utime = toMicroseconds(timeOf(t));
    wheels.x = pose.x;
    wheels.y = pose.y;
    wheels.theta = pose.theta;
    wheels.turn_rate_known = 1;
    wheels.nwheels = 0;  // the angles are not known
    lcm.publish("SLAM_WHEELS", &wheels);
    slam::imu_t imu{};  // its accelerations stay 0: not measured
    imu.utime = wheels.utime;
    imu.gyro[2] = kTurnRate;
    lcm.publish("SLAM_IMU", &imu);
    if (scan.ranges.size() < kBeams) continue;
    scan.utime = toMicroseconds(timeOf(turn_began));  // of the first beam
    scan.range_min = 0.1F;
    scan.range_max = 12.0F;
    scan.nbeams = kBeams;
    lcm.publish("SLAM_SCAN", &scan);
    scan = {};
    turn_began = t;
  }
  const Pose pose = poseAt(t);
  std::printf("at the end: x %.3f m, y %.3f m, theta %.3f rad from the start\n", pose.x, pose.y, pose.theta);
}
