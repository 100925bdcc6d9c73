// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/recorded_log.hpp"

namespace slam::recording_test {
namespace {

using testing::HasSubstr;
using testing::Not;

Recording ofALidar() {
  Recording recording;
  recording.use(recording.sensor("/scan"), &Recording::scans, 5'000'000);
  return recording;
}

TEST(RecordingConfig, IsReadBackAsItIsMeant) {
  Recording recording = ofALidar();
  recording.robot = {.lidar_x = 0.123456789,
                     .lidar_y = -0.25,
                     .lidar_yaw = -3.141592653589793,
                     .lidar_upside_down = true,
                     .mount_source = "tf\n\"[lidar]",
                     .range_min = 0.02,
                     .range_max = 29.5,
                     .range_sigma = 0.02,
                     .wheel_radius = 0.033,
                     .half_track = 0.08};
  const Config config = test::configOf(recording);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.x, 0.123456789, 1e-9);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.y, -0.25, 1e-9);
  EXPECT_NEAR(std::abs(config.front_end.lidar.T_base_lidar.theta), 3.14159265, 1e-7);
  EXPECT_TRUE(config.front_end.lidar.upside_down);
  EXPECT_NEAR(config.front_end.lidar.range_max, 29.5, 1e-9);
  EXPECT_NEAR(config.base_device.geometry.half_track, 0.08, 1e-9);
  EXPECT_EQ(config.lidar_device.driver, LidarDriver::kLcm);
  EXPECT_EQ(config.base_device.driver, BaseDriver::kNone);
  EXPECT_EQ(config.imu_device.driver, ImuDriver::kNone);
  EXPECT_EQ(config.depth_device.driver, DepthDriver::kNone);
}

TEST(RecordingConfig, IsOneThatSlamdTakesWhateverWasMeasured) {
  for (const double value : {-1e9, -0.001, 0.0, 1e-7, 1e9}) {
    Recording recording = ofALidar();
    recording.robot = {.lidar_x = value,
                       .lidar_yaw = value,
                       .range_min = value,
                       .range_max = value,
                       .wheel_radius = value,
                       .half_track = value};
    EXPECT_NO_THROW(test::configOf(recording)) << value;
  }
}

TEST(RecordingConfig, IsUtf8WhateverTheRecordingHolds) {
  Recording recording = ofALidar();
  recording.robot.mount_source = "tf from b\xFF\xC3se to B\xC3\xBCro";
  EXPECT_NO_THROW(test::configOf(recording));
  EXPECT_THAT(configText(recording, "test"), HasSubstr("B\xC3\xBCro")) << "what is UTF-8 stays";
}

TEST(RecordingDoubt, IsOfEachSensorAlone) {
  Recording recording = ofALidar();
  SensorRows& imu = recording.sensor("/imu");
  recording.use(imu, &Recording::imu, 1'000'000);
  recording.reject(imu, "file:1", "cut off");
  EXPECT_EQ(recording.doubt(), "") << "half of them";
  recording.reject(imu, "file:2", "cut off");
  EXPECT_THAT(recording.doubt(), HasSubstr("only 1 of 3 rows of /imu"));
  EXPECT_THAT(recording.doubt(), HasSubstr("cut off"));
}

TEST(RecordingReport, ReportsWhatOfEachSensorWasUsed) {
  Recording recording = ofALidar();
  for (int i = 1; i < 11; ++i) recording.use(recording.sensor("/scan"), &Recording::scans, 5'000'000 + 100'000 * i);
  recording.sensor("/scan").frame = "laser\x1b[2J";
  recording.unused.emplace_back("/camera: not read");
  const std::string report = reportText(recording, "out.lcm", true);
  EXPECT_THAT(report, HasSubstr("/scan, frame laser"));
  EXPECT_THAT(report, HasSubstr("11 used, 1.0 s at 10.0 Hz"));
  EXPECT_THAT(report, HasSubstr("not used: /camera"));
  EXPECT_THAT(report, HasSubstr("out.lcm: 11 scans, 0 wheel samples"));
  EXPECT_THAT(report, Not(HasSubstr("\x1b"))) << "no word of others moves the cursor";
}

}  // namespace
}  // namespace slam::recording_test
