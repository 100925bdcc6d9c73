// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/sensor_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "tools/files.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sensor_log_test {
namespace {

using test::Folder;
using test::refusalOf;
using testing::HasSubstr;

constexpr std::int64_t kStart = 1'700'000'000'000'000;  // [us]
constexpr DifferentialBase kBase{.wheel_radius = 0.04, .half_track = 0.15};

Config configOf(double time_offset = 0.0) {
  Config config;
  config.base_device.geometry = kBase;
  config.front_end.lidar.time_offset = time_offset;
  return config;
}

struct Content {
  bool scans = true, wheels = true, angles = true, turn_rate_known = true;
};

/// A robot that stands in a room while its wheels turn, e.g. lifted; angles of the message: left 2 rad/s, right 3
/// rad/s.
void writeLog(const std::filesystem::path& file, const Content& content) {
  const sim::Scene scene = sim::makeScene("tile-rectangle", 1);
  sim::LidarModel lidar(scene.world, {}, 1);
  EventLogWriter log(file);
  WheelOdometry odometry(kBase);
  auto scan = std::make_unique<LaserScan>();
  for (int i = 0; i < 60; ++i) {
    const std::int64_t utime = kStart + i * 50'000;
    const std::vector<double> angles{0.1 * i, 0.15 * i};
    const WheelSample sample{{}, odometry.add(angles[0], angles[1]), content.turn_rate_known};
    if (content.wheels) {
      log.writeMessage(utime, channel::kWheels,
                       toMessage(sample, utime, content.angles ? angles : std::vector<double>{}));
    }
    if (!content.scans || i % 4 != 0) continue;
    scan->size = 0;
    for (int beam = 0; beam < 360; ++beam) {
      const double bearing = wrapAngle(beam * std::numbers::pi / 180.0);
      scan->push({.range = static_cast<float>(lidar.measure({}, bearing)), .bearing = static_cast<float>(bearing)});
    }
    log.writeMessage(utime, channel::kScan, toMessage(*scan, utime));
  }
}

TEST(SensorLog, HoldsMatchesAndRecordedAngles) {
  const Folder folder;
  writeLog(folder / "a.lcm", {});
  const SensorLog log = readSensorLog(configOf(), folder / "a.lcm");
  EXPECT_TRUE(log.angles_recorded);
  ASSERT_EQ(log.wheels.size(), 60U);
  EXPECT_DOUBLE_EQ(log.wheels.back().left, 5.9);
  EXPECT_DOUBLE_EQ(log.wheels.back().right, 8.85);
  EXPECT_EQ(log.wheels.back().stamp, fromMicroseconds(kStart + 59 * 50'000));
  EXPECT_EQ(log.scans_read, 15);
  EXPECT_LE(log.scans.size(), 14U) << "the first has nothing to be matched against";
}

TEST(SensorLog, TakesAnglesBackFromTheDeadReckoning) {
  const Folder folder;
  writeLog(folder / "a.lcm", {.angles = false});
  const SensorLog log = readSensorLog(configOf(), folder / "a.lcm");
  EXPECT_FALSE(log.angles_recorded);
  ASSERT_EQ(log.wheels.size(), 60U);
  EXPECT_NEAR(log.wheels.back().left, 5.9, 1e-9);
  EXPECT_NEAR(log.wheels.back().right, 8.85, 1e-9);
}

TEST(SensorLog, StampsScansWithTheLidarsTimeOffset) {
  const Folder folder;
  writeLog(folder / "a.lcm", {});
  const SensorLog as_recorded = readSensorLog(configOf(), folder / "a.lcm");
  const SensorLog shifted = readSensorLog(configOf(-0.02), folder / "a.lcm");
  ASSERT_FALSE(as_recorded.scans.empty());
  ASSERT_FALSE(shifted.scans.empty());
  EXPECT_EQ(toMicroseconds(as_recorded.scans.front().stamp) % 50'000, kStart % 50'000);
  EXPECT_EQ(toMicroseconds(shifted.scans.front().stamp + std::chrono::milliseconds(20)) % 50'000, kStart % 50'000);
}

TEST(SensorLog, RefusesWhatCannotBeCalibratedFrom) {
  const Folder folder;
  const auto refusal = [&](const Content& content) {
    writeLog(folder / "a.lcm", content);
    return refusalOf([&] { readSensorLog(configOf(), folder / "a.lcm"); });
  };
  EXPECT_THAT(refusal({.turn_rate_known = false}), HasSubstr("a.lcm: SLAM_WHEELS measures speed only"));
  EXPECT_THAT(refusal({.scans = false}), HasSubstr("no SLAM_SCAN"));
  EXPECT_THAT(refusal({.wheels = false}), HasSubstr("no SLAM_WHEELS"));
  EXPECT_THAT(refusalOf([&] { readSensorLog(configOf(), folder / "missing.lcm"); }), HasSubstr("missing.lcm"));
}

TEST(SensorLog, CountsWhatDoesNotDecode) {
  const Folder folder;
  writeLog(folder / "a.lcm", {});
  std::string bytes = test::contentOf(folder / "a.lcm");
  bytes.insert(bytes.size() / 2, 500, 'x');
  bytes.resize(bytes.size() - 20);
  folder.write("a.lcm", bytes);
  const SensorLog log = readSensorLog(configOf(), folder / "a.lcm");
  EXPECT_GE(log.skipped_bytes, 500U);
  EXPECT_TRUE(log.truncated);
  EXPECT_GE(log.wheels.size(), 57U);
}

}  // namespace
}  // namespace slam::sensor_log_test
