// SPDX-License-Identifier: BSD-3-Clause
// Whole simulated drives, from the sensor log to the geometry.
#include <array>
#include <gtest/gtest.h>

#include "build_paths.hpp"
#include "config/loader.hpp"
#include "tools/calibrate/calibration.hpp"
#include "tools/calibrate/motion_selection.hpp"
#include "tools/files.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/log_mode.hpp"
#include "tools/sim/robot/robot_model.hpp"

namespace slam::drive_test {
namespace {

using test::Folder;

RobotGeometry truthOf(std::uint64_t seed) {
  const sim::TrueBase base = sim::RobotModel({}, seed).trueBase();
  return {base.left_radius, base.right_radius, 2.0 * base.half_track, sim::LidarModel::kExtrinsics};
}

struct Calibrated {
  RobotGeometry configured;
  Calibration result;
};

Calibrated calibrateDrive(const std::string& scene, std::uint64_t seed,
                          const std::vector<std::string>& overrides = {}) {
  const Folder folder;
  sim::writeLog({.scene = scene, .seed = seed}, folder / "drive.lcm");
  const Config config = loadConfig(SLAMD_SIM_CONFIG, overrides);
  const DifferentialBase& base = config.base_device.geometry;
  const RobotGeometry configured{base.wheel_radius, base.wheel_radius, 2.0 * base.half_track,
                                 config.front_end.lidar.T_base_lidar};
  return {configured, calibrate(selectMotions(readSensorLog(config, folder / "drive.lcm"), configured), configured)};
}

TEST(CalibratedDrive, IsNearerToTheTruthThanTheConfiguration) {
  RobotGeometry::Vector before = RobotGeometry::Vector::Zero(), after = before;  // sums of squared errors
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const auto [configured, result] = calibrateDrive("meeting-room", seed);
    ASSERT_EQ(result.status, CalibrationStatus::kDone) << "seed " << seed;
    EXPECT_GT(result.rejected, 0) << "the wheels slip now and then";
    const RobotGeometry::Vector truth = truthOf(seed).vector(), error = result.geometry.vector() - truth;
    before += (configured.vector() - truth).cwiseAbs2();
    after += error.cwiseAbs2();
    for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(error[i]), 3.0 * std::sqrt(result.covariance(i, i))) << seed;
  }
  for (const int i : {RobotGeometry::kLeftRadius, RobotGeometry::kRightRadius, RobotGeometry::kTrack}) {
    EXPECT_LT(after[i], 0.04 * before[i]) << "RMS error a fifth at most; measured: a tenth";
  }
}

TEST(CalibratedDrive, FindsALidarThatWasConfiguredWrong) {
  const auto [configured, result] = calibrateDrive("meeting-room", 1, {"lidar.x=0.0", "lidar.y=0.04", "lidar.yaw=0.1"});
  ASSERT_EQ(result.status, CalibrationStatus::kDone);
  const Pose2 error = between(sim::LidarModel::kExtrinsics, result.geometry.T_base_lidar);
  EXPECT_LT(error.translation().norm(), 0.01);
  EXPECT_LT(std::abs(error.theta), 0.01);
}

}  // namespace
}  // namespace slam::drive_test
