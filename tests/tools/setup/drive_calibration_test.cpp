// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <sstream>

#include "config/loader.hpp"
#include "tools/calibrate/gyro_scale.hpp"
#include "tools/files.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/log_mode.hpp"
#include "tools/sim/robot/robot_model.hpp"

namespace slam::drive_calibration_test {
namespace {

bool isAnyWrong(const DriveCalibration& drive) {
  return std::any_of(drive.values.begin(), drive.values.end(), [](const auto& value) { return value.is_wrong; });
}

using testing::HasSubstr;

class CalibratedSetUp : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::Folder;
    sim::writeLog({.scene = "meeting-room", .seed = 1, .depth = false}, *folder_ / "drive.lcm");
  }
  static void TearDownTestSuite() { delete folder_; }

  static inline test::Folder* folder_ = nullptr;
};

TEST_F(CalibratedSetUp, CorrectsAMountAndWheelsThatAreOff) {
  const sim::TrueBase truth = sim::RobotModel({}, 1).trueBase();
  const double radius = 0.5 * (truth.left_radius + truth.right_radius);
  const Pose2 mount = sim::LidarModel::kExtrinsics;
  Config config = loadConfig(SLAMD_SIM_CONFIG);
  config.front_end.lidar.T_base_lidar = {mount.x + 0.06, mount.y, mount.theta + 4.0 * std::numbers::pi / 180.0};
  config.base_device.geometry = {1.05 * radius, 0.95 * truth.half_track};
  const DriveCalibration drive = calibrateDrive(config, *folder_ / "drive.lcm");
  const Pose2 off = between(mount, config.front_end.lidar.T_base_lidar);
  EXPECT_LT(off.translation().norm(), 0.01);
  EXPECT_LT(std::abs(off.theta), std::numbers::pi / 180.0);
  EXPECT_NEAR(config.base_device.geometry.wheel_radius, radius, 0.005 * radius);
  EXPECT_NEAR(config.base_device.geometry.half_track, truth.half_track, 0.005 * truth.half_track);
  EXPECT_TRUE(isAnyWrong(drive));
  EXPECT_LT(drive.translation_after, 0.25 * drive.translation_before);
  EXPECT_NEAR(drive.gyro_scale, 1.0, 0.02) << "0.5 % in the simulator";
  std::ostringstream out;
  print(drive, out);
  EXPECT_THAT(out.str(), HasSubstr("wrong, changed"));

  const Config right = config;
  const DriveCalibration again = calibrateDrive(config, *folder_ / "drive.lcm");
  EXPECT_FALSE(isAnyWrong(again)) << "what is right stays";
  EXPECT_EQ(config.base_device.geometry.wheel_radius, right.base_device.geometry.wheel_radius);
}

TEST_F(CalibratedSetUp, FindsAGyroThatIsUpsideDown) {
  Config config = loadConfig(SLAMD_SIM_CONFIG);
  const SensorLog log = readSensorLog(config, *folder_ / "drive.lcm");
  SensorLog reversed = log;
  for (TurnRate& rate : reversed.turn_rates) rate.rate = -rate.rate + 0.02;
  ASSERT_TRUE(gyroScale(log) && gyroScale(reversed));
  EXPECT_NEAR(gyroScale(reversed)->value, -gyroScale(log)->value, 1e-6);
  EXPECT_NEAR(gyroScale(reversed)->bias, 0.02 - gyroScale(log)->bias, 1e-6);
  EXPECT_LT(gyroScale(log)->sigma, 0.005);
  reversed.turn_rates.clear();
  EXPECT_FALSE(gyroScale(reversed)) << "there is no gyro";
}

TEST_F(CalibratedSetUp, RefusesADriveThatIsTooShort) {
  sim::writeLog({.scene = "meeting-room", .seed = 1, .seconds = 6.0, .depth = false}, *folder_ / "short.lcm");
  Config config = loadConfig(SLAMD_SIM_CONFIG);
  EXPECT_THAT(test::refusalOf([&] { calibrateDrive(config, *folder_ / "short.lcm"); }),
              HasSubstr("the robot drove too little"));
}

}  // namespace
}  // namespace slam::drive_calibration_test
