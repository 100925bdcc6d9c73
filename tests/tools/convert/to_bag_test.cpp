// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <slam/odometry_t.hpp>

#include "tools/convert/bags/ros2_bag.hpp"
#include "tools/convert/bags/ros_messages.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/formats.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kBegin = 1'700'000'000'000'000;  // [us]
constexpr int kScans = 40, kBeams = 90;

struct ToBag : testing::TestWithParam<const char*> {
  void writeLog(bool even) const {
    EventLogWriter log(folder / "in.lcm");
    config_t config{};
    config.utime = kBegin;
    config.configuration = "[lidar]\nx = 0.2\ny = -0.1\nyaw = 1.5\n";
    log.writeMessage(kBegin, channel::kConfig, config);
    for (int i = 0; i < kScans; ++i) {
      const std::int64_t t = kBegin + 100'000 * i;
      LaserScan scan;
      scan.range_min = 0.1F;
      scan.range_max = 10.0F;
      for (int k = 0; k < kBeams; ++k) {
        const float bearing = -0.04F * static_cast<float>(k) + (even || k % 2 == 0 ? 0.0F : 0.015F);
        scan.push({.range = k == 7 ? 0.0F : 1.0F + 0.01F * static_cast<float>(k + i),
                   .bearing = bearing,
                   .time_offset = 0.001F * static_cast<float>(k)});
      }
      log.writeMessage(t + 1000, channel::kScan, toMessage(scan, t));
      wheels_t wheels = toMessage(WheelSample{fromMicroseconds(t), {0.1 * i, 0.02 * i, 0.01 * i}}, t);
      wheels.nwheels = 2;
      wheels.angles = {1.0 * i, 2.0 * i};
      log.writeMessage(t + 2000, channel::kWheels, wheels);
      log.writeMessage(t + 2000, channel::kImu, toMessage(ImuSample{fromMicroseconds(t), {0, 0, 0.5}, {0, 0, 9.8}}, t));
      odometry_t odometry{};
      odometry.utime = t;
      odometry.x = 0.1 * i;
      odometry.map_odom[0] = 3.0;
      log.writeMessage(t + 3000, channel::kOdometry, odometry);
      pose_estimate_t pose{};
      pose.utime = t;
      pose.x = 3.0 + 0.1 * i;
      log.writeMessage(t + 3000, channel::kSlamPose, pose);
    }
    map_meta_t meta{};
    meta.utime = kBegin;
    meta.resolution = 0.05;
    meta.tile_side = 2;
    map_tile_t tile{};
    tile.utime = kBegin;
    tile.side = 2;
    tile.ncells = 4;
    tile.cells = {0, 100, 255, 50};
    log.writeMessage(kBegin + 4'000'000, channel::kMapMeta, meta);
    log.writeMessage(kBegin + 4'000'000, channel::kMapTile, tile);
    log.write(kBegin + 4'000'000, channel::kScan, std::vector<std::uint8_t>{1, 2, 3});
    log.write(kBegin + 4'000'000, "CAMERA", std::vector<std::uint8_t>{1, 2, 3});
  }
  std::filesystem::path bag() const { return folder / (std::string("out.") + GetParam()); }

  test::Folder folder;
};

TEST_P(ToBag, GivesTheSameLogBack) {
  writeLog(true);
  const Recording written = convertToBag(folder / "in.lcm", bag());
  EXPECT_EQ(written.scans, kScans);
  EXPECT_EQ(written.rejected, 1);
  EXPECT_THAT(written.unused, testing::ElementsAre(HasSubstr("CAMERA")));
  const Recording read = convertRos(bag(), folder / "back.lcm", {.odometry = "/odom"});
  EXPECT_EQ(read.rejected, 0);
  EXPECT_NEAR(read.robot.lidar_x, 0.2, 1e-9);
  EXPECT_NEAR(read.robot.lidar_y, -0.1, 1e-9);
  EXPECT_NEAR(read.robot.lidar_yaw, 1.5, 1e-9);
  const test::Log before = test::readLog(folder / "back.lcm");
  ASSERT_EQ(before.scans.size(), static_cast<std::size_t>(kScans));
  for (int i = 0; i < kScans; ++i) {
    EXPECT_EQ(before.scan_utimes[static_cast<std::size_t>(i)], kBegin + 100'000 * i);
    const LaserScan& scan = before.scans[static_cast<std::size_t>(i)];
    ASSERT_EQ(scan.size, kBeams);
    for (int k = 0; k < kBeams; ++k) {
      const Beam& beam = scan.storage[static_cast<std::size_t>(k)];
      if (k == 7) {
        EXPECT_FALSE(scan.isReturn(beam));
      } else {
        EXPECT_FLOAT_EQ(beam.range, 1.0F + 0.01F * static_cast<float>(k + i));
      }
      EXPECT_NEAR(wrapAngle(beam.bearing + 0.04 * k), 0.0, 1e-5);
      EXPECT_NEAR(beam.time_offset, 0.001 * k, 1e-5);
    }
  }
  ASSERT_EQ(before.wheels.size(), static_cast<std::size_t>(kScans));
  const Pose2 way = between(before.wheels.front().T_wheels_base, before.wheels.back().T_wheels_base);
  EXPECT_NEAR(way.x, 0.1 * (kScans - 1), 1e-9);
  EXPECT_NEAR(way.theta, 0.01 * (kScans - 1), 1e-9);
  ASSERT_EQ(before.imu_samples.size(), static_cast<std::size_t>(kScans));
  EXPECT_DOUBLE_EQ(before.imu_samples[3].gyro.z(), 0.5);
  EXPECT_DOUBLE_EQ(before.imu_samples[3].accel.z(), 9.8);
}

TEST_P(ToBag, HasTopicsWithTheirTypesAndDefinitions) {
  writeLog(true);
  convertToBag(folder / "in.lcm", bag());
  std::map<std::string, std::pair<std::string, int>> topics;
  std::string cells;
  const auto source = openRosFile(bag());
  for (RosMessage message; source->next(message);) {
    EXPECT_EQ(message.topic->encoding, RosEncoding::kCdr);
    EXPECT_NE(message.topic->definition, "") << message.topic->name;
    if (ros::isRead(message.topic->type)) {
      EXPECT_EQ(ros::refusal(*message.topic), "");
      EXPECT_TRUE(ros::read(message)) << message.topic->name;
    }
    auto& [type, count] = topics[message.topic->name];
    type = message.topic->type;
    ++count;
    if (message.topic->name == "/map")
      cells.assign(reinterpret_cast<const char*>(message.data.data()) + message.data.size() - 4, 4);
  }
  EXPECT_EQ(source->damages(), 0);
  using Topic = std::pair<std::string, int>;
  EXPECT_EQ(topics["/scan"], Topic("sensor_msgs/LaserScan", kScans));
  EXPECT_EQ(topics["/odom"], Topic("nav_msgs/Odometry", kScans));
  EXPECT_EQ(topics["/odometry/filtered"], Topic("nav_msgs/Odometry", kScans));
  EXPECT_EQ(topics["/joint_states"], Topic("sensor_msgs/JointState", kScans));
  EXPECT_EQ(topics["/imu"], Topic("sensor_msgs/Imu", kScans));
  EXPECT_EQ(topics["/pose"], Topic("geometry_msgs/PoseWithCovarianceStamped", kScans));
  EXPECT_EQ(topics["/tf"], Topic("tf2_msgs/TFMessage", 2 * kScans));
  EXPECT_EQ(topics["/tf_static"], Topic("tf2_msgs/TFMessage", 1));
  EXPECT_EQ(topics["/map"], Topic("nav_msgs/OccupancyGrid", 1));
  EXPECT_EQ(cells, std::string("\0\x64\xFF\x32", 4));
}

TEST_P(ToBag, PutsUnevenBeamsOnEvenBearings) {
  writeLog(false);
  convertToBag(folder / "in.lcm", bag());
  convertRos(bag(), folder / "back.lcm", {.odometry = "/odom"});
  const test::Log log = test::readLog(folder / "back.lcm");
  ASSERT_EQ(log.scans.size(), static_cast<std::size_t>(kScans));
  const LaserScan& scan = log.scans.front();
  int returns = 0;
  for (const Beam& beam : scan.beams()) {
    if (!scan.isReturn(beam)) continue;
    ++returns;
    EXPECT_GE(beam.range, 1.0F);
    EXPECT_LT(beam.range, 1.0F + 0.01F * kBeams);
  }
  EXPECT_GT(returns, kBeams / 2);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ToBag, testing::Values("db3", "mcap"));

TEST(ToBagNames, AreThoseOfABag) {
  const test::Folder folder;
  EventLogWriter(folder / "in.lcm").flush();
  EXPECT_THAT(test::refusalOf([&] { convertToBag(folder / "in.lcm", folder / "out.bag"); }),
              HasSubstr(".db3 or .mcap"));
  EXPECT_THAT(test::refusalOf([&] { convertToBag(folder / "in.lcm", folder / "out.db3"); }), HasSubstr("no LCM event"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.db3")) << "half a bag is none";
}

}  // namespace
}  // namespace slam
