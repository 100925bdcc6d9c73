// SPDX-License-Identifier: BSD-3-Clause
#include <bit>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bus/event_log.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::mbot_test {
namespace {

using test::Log;
using testing::HasSubstr;

constexpr std::int64_t kNow = 1'500'000'000'000'000, kRobot = 40'000'000;  // [us] clocks of logger and robot

/// Big-endian fields, as LCM has them.
class Fields {
 public:
  explicit Fields(std::uint64_t type) { put(type, 8); }
  Fields& int64(std::int64_t value) { return put(static_cast<std::uint64_t>(value), 8); }
  Fields& int32(std::int32_t value) { return put(static_cast<std::uint32_t>(value), 4); }
  Fields& int16(std::int16_t value) { return put(static_cast<std::uint16_t>(value), 2); }
  Fields& real(float value) { return put(std::bit_cast<std::uint32_t>(value), 4); }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  Fields& put(std::uint64_t value, int size) {
    for (int i = size - 1; i >= 0; --i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
  }
  std::vector<std::uint8_t> bytes_;
};

std::vector<std::uint8_t> scan(std::int64_t utime, std::int64_t first, int beams, std::int64_t step) {
  Fields fields(0x89dc5b879a5056cf);
  fields.int64(utime).int32(beams);
  for (int i = 0; i < beams; ++i) fields.real(2.0F);
  for (int i = 0; i < beams; ++i) fields.real(0.01F * static_cast<float>(i));
  for (int i = 0; i < beams; ++i) fields.int64(first + step * i);
  for (int i = 0; i < beams; ++i) fields.real(1.0F);
  return fields.bytes();
}

/// Two seconds of an MBot: the lidar turns in 0.15 s, and a scan arrives 1 ms behind its last beam.
/// @param copied [us] between beam times, which are those of a copy at the turn's end; nullopt: they are measured
void writeLog(const std::filesystem::path& file, bool encoders, bool stamped_at_end = false,
              std::optional<std::int64_t> copied = std::nullopt) {
  EventLogWriter log(file);
  for (int i = 0; i < 100; ++i) {
    const std::int64_t t = 20'000 * i;
    if (encoders) {
      log.write(
          kNow + t + 1'000, "MBOT_ENCODERS",
          Fields(0xa8b04e85ffa9d1d1).int64(kRobot + t).int64(100 * i).int64(200 * i).int16(100).int16(200).bytes());
    }
    log.write(kNow + t + 1'000, "ODOMETRY",
              Fields(0x1f317af1246276ac).int64(kRobot + t).real(0.01F * static_cast<float>(i)).real(0).real(0).bytes());
    Fields imu(0x5d3f1ec742142382);
    imu.int64(kRobot + t);
    for (const float value : {0.0F, 0.0F, 90.0F, 0.0F, 0.0F, 9.8F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F})
      imu.real(value);
    log.write(kNow + t + 1'000, "MBOT_IMU", imu.bytes());
    if (i % 10 != 9) continue;
    const std::int64_t first = kRobot + t - 150'000;
    log.write(kNow + t + 1'000, "LIDAR",
              copied ? scan(kRobot + t, kRobot + t, 101, *copied)
                     : scan(stamped_at_end ? kRobot + t : first, first, 101, 1'500));
  }
}

TEST(Mbot2017, ConvertsWithWheelsAndImu) {
  const test::Folder folder;
  writeLog(folder / "in.lcm", true);
  const Recording recording = convertAny(folder / "in.lcm", folder / "out.lcm");
  EXPECT_EQ(recording.scans, 10);
  EXPECT_EQ(recording.wheels, 100);
  EXPECT_EQ(recording.imu, 100);
  EXPECT_EQ(recording.rejected, 0) << recording.first_rejection;
  const Log log = test::readLog(folder / "out.lcm");
  EXPECT_NEAR(log.imu_samples[0].gyro.z(), 1.5708, 1e-4);
  EXPECT_NEAR(log.imu_samples[0].accel.z(), 9.8, 1e-5);
  EXPECT_NEAR(log.wheels[1].T_wheels_base.theta, 100 * 1.540e-4 / 0.210, 1e-6);
  const Config config = test::configOf(recording);
  EXPECT_NEAR(config.base_device.geometry.half_track, 0.105, 1e-9);
  ASSERT_EQ(log.angles[99].size(), 2U);
  EXPECT_NEAR(log.angles[99][1] * config.base_device.geometry.wheel_radius, 200 * 99 * 1.540e-4, 1e-9);
}

TEST(Mbot2017, StampsAScanWithItsFirstBeam) {
  for (const bool stamped_at_end : {false, true}) {
    const test::Folder folder;
    writeLog(folder / "in.lcm", true, stamped_at_end);
    convertMbot(folder / "in.lcm", folder / "out.lcm");
    const Log log = test::readLog(folder / "out.lcm");
    ASSERT_EQ(log.scans.size(), 10U);
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_EQ(log.scan_events[i] - log.scan_utimes[i], 150'000) << "the least delay counts as none";
      EXPECT_NEAR(log.scans[i].beams().back().time_offset, 0.15, 1e-6);
      EXPECT_EQ(log.scans[i].beams().front().time_offset, 0.0F);
    }
    // Wheels of the same time have the same stamp.
    EXPECT_EQ(toMicroseconds(log.wheels[9].stamp), log.scan_utimes[0] + 150'000);
  }
}

TEST(Mbot2017, TakesScansOfOneTimeForTheTurnBefore) {
  for (const std::int64_t step : {0, 2}) {  // [us] from copy to copy
    const test::Folder folder;
    writeLog(folder / "in.lcm", true, false, step);
    const Recording recording = convertAny(folder / "in.lcm", folder / "out.lcm");
    EXPECT_THAT(recording.notes, testing::Contains(HasSubstr("over the 0.200 s before")));
    const Log log = test::readLog(folder / "out.lcm");
    ASSERT_EQ(log.scans.size(), 10U);
    EXPECT_NEAR(static_cast<double>(toMicroseconds(log.wheels[9].stamp) - log.scan_utimes[0]), 200'000,
                100.0 * static_cast<double>(step));
    EXPECT_EQ(log.scans[0].beams().back().time_offset, 0.0F) << "slamd finds out which way it turns";
  }
}

TEST(Mbot2017, MendsOurLogsOfSuchScansOnce) {
  const test::Folder folder;
  const auto write = [&](float step) {
    LogOutput log;
    auto scan = std::make_unique<LaserScan>();
    for (int i = 0; i < 20; ++i) {
      scan->size = 0;
      for (int k = 0; k < 100; ++k)
        scan->push({.range = 2.0F, .bearing = 0.01F, .time_offset = step * static_cast<float>(k)});
      scan->stamp = fromMicroseconds(kNow + 100'000 * i);
      log.add(kNow + 100'000 * i, *scan, kNow + 100'000 * i);
    }
    log.write(folder / "in.lcm");
  };
  write(1e-6F);
  convertAny(folder / "in.lcm", folder / "out.lcm");
  EXPECT_EQ(test::readLog(folder / "out.lcm").scan_utimes[3], kNow + 200'000);
  EXPECT_THAT(convertAny(folder / "out.lcm", folder / "again.lcm").notes, testing::IsEmpty());
  EXPECT_EQ(test::readLog(folder / "again.lcm").scan_utimes[3], kNow + 200'000);
  for (const float step : {0.0F, 9e-4F}) {  // not said; measured
    write(step);
    EXPECT_THAT(convertAny(folder / "in.lcm", folder / "out.lcm").notes, testing::IsEmpty());
    EXPECT_EQ(test::readLog(folder / "out.lcm").scan_utimes[3], kNow + 300'000);
  }
}

TEST(Mbot2017, WritesThePosesOfTheLogOnItsOwnClock) {
  const test::Folder folder;
  {
    EventLogWriter log(folder / "in.lcm");
    const auto pose = [](std::int64_t t, float x) { return Fields(0x1f317af1246276ac).int64(kRobot + t).real(x); };
    for (int i = 0; i < 3; ++i) {  // the second pose arrives late
      const std::int64_t t = 100'000 * i, arrival = kNow + t + (i == 1 ? 30'000 : 2'000);
      log.write(arrival, "SLAM_POSE", pose(t, 0.5F * static_cast<float>(i)).real(-1.0F).real(0.25F).bytes());
      log.write(arrival, "TRUE_POSE", pose(t, 9.0F).real(9.0F).real(0.0F).bytes());
    }
    log.write(kNow + 252'000, "SLAM_POSE", pose(250'000, 1.0F).bytes());
    log.write(kNow + 300'000, "LIDAR", scan(kRobot, kRobot, 1, 0));
  }
  const Recording recording = convertMbot(folder / "in.lcm", folder / "out.lcm", {.file = folder / "truth.tum"});
  EXPECT_EQ(recording.poses, 3);
  EXPECT_EQ(recording.rejected, 1);
  const Trajectory poses = readTrajectory(folder / "truth.tum");
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(toMicroseconds(poses[1].stamp), kNow + 2'000 + 100'000) << "the least delay counts as none";
  EXPECT_NEAR(poses[1].pose.x, 0.5, 1e-6);
  EXPECT_NEAR(poses[1].pose.y, -1.0, 1e-6);
  EXPECT_NEAR(poses[1].pose.theta, 0.25, 1e-6);
  convertMbot(folder / "in.lcm", folder / "out.lcm", {.file = folder / "truth.tum", .channel = "TRUE_POSE"});
  EXPECT_NEAR(readTrajectory(folder / "truth.tum")[0].pose.x, 9.0, 1e-6);
  EXPECT_THROW(convertMbot(folder / "in.lcm", folder / "out.lcm", {.file = folder / "truth.tum", .channel = "NONE"}),
               std::runtime_error);
}

TEST(Mbot2017, TakesOdometryWhereThereAreNoEncoders) {
  const test::Folder folder;
  writeLog(folder / "in.lcm", false);
  EXPECT_EQ(convertMbot(folder / "in.lcm", folder / "out.lcm").wheels, 100);
  EXPECT_NEAR(test::readLog(folder / "out.lcm").wheels[99].T_wheels_base.x, 0.99, 1e-6);
}

TEST(Mbot2017, TakesTicksAndWidthFromOptions) {
  const test::Folder folder;
  writeLog(folder / "in.lcm", true);
  const Recording recording = convertMbot(folder / "in.lcm", folder / "out.lcm", {},
                                          {.metres_per_tick = 1e-3, .width = 0.5, .wheel_radius = 0.04});
  const Log log = test::readLog(folder / "out.lcm");
  EXPECT_NEAR(log.wheels[1].T_wheels_base.theta, 0.1 / 0.5, 1e-6);
  EXPECT_NEAR(log.angles[1][0], 0.1 / 0.04, 1e-9);
  EXPECT_NEAR(test::configOf(recording).base_device.geometry.wheel_radius, 0.04, 1e-9);
}

TEST(Mbot2017, RefusesTimesThatAreNone) {
  const test::Folder folder;
  {
    EventLogWriter log(folder / "in.lcm");
    for (const std::int64_t bad :
         {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min(), std::int64_t{1} << 58}) {
      log.write(bad, "MBOT_ENCODERS", Fields(0xa8b04e85ffa9d1d1).int64(kRobot).bytes());
      log.write(kNow, "LIDAR", scan(bad, bad, 3, 0));
      log.write(kNow, "MBOT_ENCODERS",
                Fields(0xa8b04e85ffa9d1d1).int64(bad).int64(bad).int64(bad).int16(0).int16(0).bytes());
    }
    log.write(kNow + 1'000, "LIDAR", scan(kRobot, kRobot, 3, 1'000));
  }
  const Recording recording = convertMbot(folder / "in.lcm", folder / "out.lcm");
  EXPECT_EQ(recording.scans, 1);
  EXPECT_EQ(recording.rejected, 9);
  EXPECT_THAT(recording.doubt(), HasSubstr("rows of"));
}

}  // namespace
}  // namespace slam::mbot_test
