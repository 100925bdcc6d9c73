// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_pictures.hpp"

#include <gtest/gtest.h>

#include "config/loader.hpp"
#include "tools/files.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/log_mode.hpp"
#include "tools/sim/robot/robot_model.hpp"

namespace slam::drive_pictures_test {
namespace {

TEST(DrivePictures, AreThinnerWhereTheWheelsAreRight) {
  const test::Folder folder;
  const std::filesystem::path log = folder / "drive.lcm";
  sim::writeLog({.scene = "meeting-room", .seed = 1, .seconds = 40.0, .depth = false}, log);
  const sim::TrueBase truth = sim::RobotModel({}, 1).trueBase();
  Config right = loadConfig(SLAMD_SIM_CONFIG);
  right.front_end.lidar.T_base_lidar = sim::LidarModel::kExtrinsics;
  right.base_device.geometry = {0.5 * (truth.left_radius + truth.right_radius), truth.half_track};
  Config wrong = right;
  wrong.base_device.geometry.half_track *= 0.7;
  const ColourImage picture = scansOverWheels(wrong, right, log);
  int inked[2] = {0, 0};  // pixels of either half
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column)
      inked[2 * column / picture.width] += picture.at(column, row).red < 100 ? 1 : 0;
  }
  EXPECT_GT(inked[1], 1000);
  EXPECT_LT(inked[1], inked[0] * 3 / 4) << "walls that are drawn over and over are not smeared";
  EXPECT_EQ(mapOfDrive(right, log, folder / "").substr(1, 3), "PNG");
  EXPECT_NE(test::refusalOf([&] { scansOverWheels(right, right, folder / "none.lcm"); }), "");
}

}  // namespace
}  // namespace slam::drive_pictures_test
