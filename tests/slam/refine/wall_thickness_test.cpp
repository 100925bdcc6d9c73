// SPDX-License-Identifier: BSD-3-Clause
#include "slam/refine/wall_thickness.hpp"

#include <gtest/gtest.h>

#include "support/simulated/mapped_drive.hpp"

namespace slam {
namespace {

using test::MappedDrive;

TEST(WallThickness, IsThatOfTheRangesWherePosesAreTrue) {
  MappedDrive drive = test::mapped(test::ringCorridor(), test::alongRing(0.0, 10.0), 1);
  for (int id = 0; id < drive.map.keyframes.size(); ++id)
    drive.map.keyframes.graph().setPose(id, drive.truth[static_cast<std::size_t>(id)]);
  const double thickness = wallThickness(drive.map.keyframes, drive.map.in_map);
  EXPECT_GT(thickness, 0.001);
  EXPECT_LT(thickness, 0.02);
}

TEST(WallThickness, RisesWithPosesThatContradictEachOther) {
  MappedDrive drive = test::mapped(test::ringCorridor(), test::alongRing(0.0, 10.0), 1);
  const double before = wallThickness(drive.map.keyframes, drive.map.in_map);
  for (int id = 0; id < drive.map.keyframes.size(); id += 2) {
    Pose2 pose = drive.map.keyframes.pose(id);
    pose.x += 0.05, pose.y += 0.05;
    drive.map.keyframes.graph().setPose(id, pose);
  }
  EXPECT_GT(wallThickness(drive.map.keyframes, drive.map.in_map), 1.5 * before);
}

TEST(WallThickness, LeavesOutWhatIsNotInTheMap) {
  MappedDrive drive = test::mapped(test::ringCorridor(), test::alongRing(0.0, 4.0), 1);
  std::fill(drive.map.in_map.begin(), drive.map.in_map.end(), 0);
  EXPECT_EQ(wallThickness(drive.map.keyframes, drive.map.in_map), 0.0);
}

}  // namespace
}  // namespace slam
