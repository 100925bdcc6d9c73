// SPDX-License-Identifier: BSD-3-Clause
#include <functional>
#include <iomanip>
#include <memory>
#include <sstream>

#include "app/observables.hpp"
#include "app/recorded_drive.hpp"
#include "bus/checked_decode.hpp"
#include "frontend/front_end.hpp"
#include "support/simulated/keyframes.hpp"
#include "tools/files.hpp"
#include "tools/replay/replay.hpp"

namespace slam::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A log that is written once for all tests of this process.
class Log {
 public:
  explicit Log(const std::function<void(const std::filesystem::path&)>& write) { write(file); }
  Folder folder;
  const std::filesystem::path file = folder / "drive.lcm";
};

void countersInto(std::ostream& out, const ReplayStats& stats) {
  const auto add = [&](const CounterInfo&, const auto& value) { out << value << ' '; };
  visitCounters(stats.front_end, add);
  visitCounters(stats.back_end, add);
  for (const std::string& warning : stats.warnings) out << warning << '\n';
}

std::string replayed(const Config& config, const Log& log) {
  const Folder folder;
  ReplayOptions options;
  options.logs = {log.file};
  options.trajectory = folder / "final.tum";
  options.causal = folder / "causal.tum";
  options.odometry = folder / "odometry.tum";
  options.estimates = folder / "estimates.csv";
  options.map = folder / "map";
  std::ostringstream text;
  try {
    countersInto(text, replay(config, options));
  } catch (const std::runtime_error& refusal) {
    return refusal.what();
  }
  for (const char* name : {"final.tum", "causal.tum", "odometry.tum", "estimates.csv", "map.yaml", "map.pgm"})
    text << contentOf(folder / name);
  return text.str();
}

const Log& plainLog() {
  static const Log log([](const auto& file) {
    RecordedDrive drive(furnishedRoom(), {-2.0, -0.3, 0.2});
    drive.has_depth = true;
    drive.run(1.2, {0, 0, 0});
    drive.run(3.0, {0.4, 0, 0.35});
    drive.run(1.6, {0.2, 0, -0.9});
    drive.run(0.8, {0, 0, 0});
    drive.save(file);
  });
  return log;
}

const Log& withoutGyroLog() {
  static const Log log([](const auto& file) {
    RecordedDrive drive(furnishedRoom(), {-2.0, -0.3, 0.2});
    drive.gyro.there = false;
    drive.run(1.0, {0, 0, 0});
    drive.run(2.0, {0.4, 0, 0.35});
    drive.wheels.leap({0.0, 0.0, 0.5});
    drive.run(1.0, {0.4, 0, 0.35});
    drive.save(file);
  });
  return log;
}

const Log& roughLog() {
  static const Log log([](const auto& file) {
    RecordedDrive drive(furnishedRoom(), {-2.0, -0.3, 0.2});
    drive.run(1.4, {0, 0, 0});
    drive.run(1.0, {0.4, 0, 0.3});
    drive.wheels.leap({1.0, 0.0, 0.0});
    drive.run(0.4, {0.4, 0, 0.3});
    drive.wheels.spin.x() = 0.6;
    drive.run(0.6, {0.0, 0, 0.5});
    drive.wheels.spin.x() = 0.0;
    drive.run(1.0, {0.4, 0, 0.2});
    drive.gyro.there = false;
    drive.run(0.6, {0.2, 0, 0.9});
    drive.gyro.there = true;
    drive.wheels.there = false;
    drive.run(1.4, {0.3, 0, -0.9});
    drive.wheels.there = true;
    drive.delay = 0.6;
    drive.run(0.4, {0.3, 0, -0.3});
    drive.delay = 0.0;
    drive.run(0.8, {0.3, 0, -0.3});
    drive.dazzled = 0.6;
    drive.run(2.0, {0.1, 0, 0.5});
    drive.dazzled = 0.0;
    drive.lidar.there = false;
    drive.run(1.6, {0.0, 0, 0.4});
    drive.lidar.there = true;
    drive.run(0.6, {0.0, 0, 0.0});
    drive.save(file);
  });
  return log;
}

const Log& spinningLog() {
  static const Log log([](const auto& file) {
    RecordedDrive drive(furnishedRoom(), {-1.0, 0.9, 0.0}, 6);
    drive.run(0.8, {0, 0, 0});
    drive.run(1.2, {0.4, 0, -0.4});
    drive.gyro.there = false;
    drive.wheels.spin.x() = 1.5;
    drive.dazzled = 0.35;
    drive.run(1.8, {0.2, 0, -0.4});
    drive.wheels.spin.x() = drive.dazzled = 0.0;
    drive.run(9.0, {0.4, 0, -0.6});
    drive.truth = drive.truth * Pose2{0.7, 0.3, 0.7};
    drive.run(1.0, {0, 0, 0});
    drive.save(file);
  });
  return log;
}

/// A room and a crooked hall with a door between them.
Place roomAndHall() {
  Place place{.name = "RoomAndHall", .low = {0.3, 0.3}, .high = {13.7, 4.7}, .reach = 10.0};
  addWalls(place.world, {{0, 0}, {6, 0}, {16, -3}, {14, 4}, {10, 8}, {6, 5}, {0, 5}});
  place.world.addWall({6.0, 0.0}, {6.0, 1.9});
  place.world.addWall({6.0, 3.1}, {6.0, 5.0});
  place.world.add(sim::Box{1.0, 4.3, 0.0, 1.5, 0.9});
  place.world.add(sim::Box{4.6, 0.7, 0.4, 1.0, 0.7});
  place.world.add(sim::Cylinder{9.0, 1.4, 0.3});
  place.world.add(sim::Box{12.3, 1.5, 0.7, 0.9, 0.6});
  return place;
}

const Log& carriedLog() {
  static const Log log([](const auto& file) {
    RecordedDrive drive(roomAndHall(), {1.2, 2.5, 0.0});
    drive.run(0.6, {0, 0, 0});
    drive.run(9.0, {1.0, 0, 0});
    drive.run(1.0, {0, 0, kPi / 2});
    drive.run(2.5, {1.0, 0, 0});
    drive.truth = {2.8, 1.6, 0.0};
    drive.run(2.4, {0, 0, 0.0});
    drive.run(8.0, {0.4, 0.0, 0.6});
    drive.save(file);
  });
  return log;
}

const Log& ringLog() {
  static const Log log([](const auto& file) {
    RecordedDrive drive(ringCorridor(), onRing(0.5));
    drive.run(0.6, {0, 0, 0});
    for (const double side : {11.5, 8.0, 12.0, 8.0, 9.0}) {
      drive.run(side, {1.0, 0, 0});
      drive.run(1.0, {0, 0, kPi / 2});
    }
    drive.save(file);
  });
  return log;
}

}  // namespace

std::string drive(const Config& config) { return replayed(config, plainLog()); }
std::string driveWithoutGyro(const Config& config) { return replayed(config, withoutGyroLog()); }
std::string roughDrive(const Config& config) { return replayed(config, roughLog()); }
std::string spinningWheels(const Config& config) { return replayed(config, spinningLog()); }
std::string kidnapped(const Config& config) { return replayed(config, carriedLog()); }
std::string ringDrive(const Config& config) { return replayed(config, ringLog()); }

std::string states(const Config& config) {
  FrontEnd front_end(frontEndConfig(config));
  EventLogReader log(roughLog().file);
  std::ostringstream text;
  text << std::setprecision(6);
  for (LogEvent event; log.next(event);) {
    if (event.channel == channel::kWheels) front_end.add(*fromMessage(*decodeChecked<wheels_t>(event.data)));
    if (event.channel == channel::kImu) front_end.add(*fromMessage(*decodeChecked<imu_t>(event.data)));
    if (event.channel == channel::kScan) front_end.add(*fromMessage(*decodeChecked<scan_t>(event.data)));
    const Timestamp now = fromMicroseconds(event.utime);
    const PoseEstimate pose = front_end.estimate(now);
    const OdometryEstimate odometry = front_end.odometry(now);
    text << nameOf(pose.state) << ' ' << pose.T_map_base.vector().transpose() << ' '
         << pose.covariance.diagonal().transpose() << ' ' << odometry.T_odom_base.vector().transpose() << ' '
         << odometry.covariance.diagonal().transpose() << ' ' << odometry.twist.vx << ' ' << odometry.twist.omega << ' '
         << odometry.gyro_bias << odometry.slip << odometry.standstill << '\n';
  }
  return text.str();
}

}  // namespace slam::test
