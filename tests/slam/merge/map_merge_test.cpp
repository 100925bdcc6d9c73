// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/map_merge.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/simulated/mapped_drive.hpp"

namespace slam::map_merge_test {
namespace {

using Outcome = MergeReport::Outcome;
using test::MappedDrive;

/// [m] largest error of a keyframe of the second map relative to the first keyframe of the first one.
double worst(const MapState& map, const MappedDrive& first, const MappedDrive& second) {
  double largest = 0.0;
  for (std::size_t i = 0; i < second.truth.size(); ++i) {
    const int id = first.map.keyframes.size() + static_cast<int>(i);
    const Pose2 error =
        between(between(first.truth.front(), second.truth[i]), between(map.keyframes.pose(0), map.keyframes.pose(id)));
    largest = std::max(largest, std::hypot(error.x, error.y));
  }
  return largest;
}

struct RingMerge : testing::Test {
  const MappedDrive first = test::mapped(test::ringCorridor(), test::alongRing(0.0, 24.0), 1);
  const MappedDrive second = test::mapped(test::ringCorridor(), test::alongRing(14.0, 38.0), 2);
};

TEST_F(RingMerge, PutsTwoPartsOfADriveWhereTheyWere) {
  const MergedMap result = test::merged(first.map, second.map);
  ASSERT_EQ(result.report.outcome, Outcome::kMerged);
  EXPECT_LT(worst(*result.map, first, second), 0.06);
  EXPECT_LT(result.report.residual, 0.02);
  EXPECT_GE(result.report.registration.found.size(), 3u);
  EXPECT_GT(result.report.registration.overlap, 0.2);
  EXPECT_TRUE(test::sameCells(result.map->grid, test::drawn(*result.map)));
  const Pose2 moved = between(first.map.keyframes.pose(50), result.map->keyframes.pose(50));
  EXPECT_LT(std::hypot(moved.x, moved.y), 0.03) << "the first map's frame stays";
}

TEST_F(RingMerge, KeepsTheCellsOfTheFirstMap) {
  MappedDrive fine = test::mapped(test::ringCorridor(), test::alongRing(0.0, 24.0), 1);
  OccupancyGridConfig cells = test::smallGrid();
  cells.resolution = 0.05;
  fine.map.grid = OccupancyGrid(cells);
  const MergedMap result = test::merged(fine.map, second.map);
  ASSERT_TRUE(result.map);
  EXPECT_EQ(result.map->grid.resolution(), 0.05);
}

TEST_F(RingMerge, RefusesACopyAnEmptyMapAndAFloorPlan) {
  EXPECT_EQ(test::merged(first.map, first.map).report.outcome, Outcome::kShared);
  EXPECT_EQ(test::merged(first.map, MapState()).report.outcome, Outcome::kNoKeyframes);
  MappedDrive plan = test::mapped(test::ringCorridor(), test::alongRing(0.0, 2.0), 1);
  plan.map.kind = MapKind::kFloorPlan;
  EXPECT_EQ(test::merged(plan.map, second.map).report.outcome, Outcome::kNoKeyframes);
}

TEST_F(RingMerge, KeepsTheEditsAndPlacesOfBoth) {
  MappedDrive a = test::mapped(test::ringCorridor(), test::alongRing(0.0, 24.0), 1);
  MappedDrive b = test::mapped(test::ringCorridor(), test::alongRing(14.0, 38.0), 2);
  ASSERT_EQ(test::edit(a.map, test::squareEdit(EditKind::kNoGo, 1.0, 0.0)), "");
  EditCommand dock = test::squareEdit(EditKind::kPlace, 1.0, 0.3);
  dock.request.points.resize(1);
  dock.request.name = "dock";
  dock.request.theta = 0.5;
  dock.request.sigma = {0.1, 0.2, 0.05};
  ASSERT_EQ(test::edit(b.map, dock), "");
  ASSERT_EQ(test::edit(b.map, test::squareEdit(EditKind::kErase, 2.0, 0.5)), "");
  MergedMap result = test::merged(a.map, b.map);
  ASSERT_TRUE(result.map);
  MapState& map = *result.map;
  ASSERT_EQ(map.edits.edits.size(), 3u);
  EXPECT_EQ(map.edits.made, 3);
  const MapEdit& place = map.edits.edits[1];
  EXPECT_EQ(place.name, "dock");
  const Pose2 T_first_second = between(a.truth.front(), b.truth.front());
  const Pose2 error = between(T_first_second * Pose2{1.0, 0.3, 0.5}, poseOf(place, map.keyframes));
  EXPECT_LT(std::hypot(error.x, error.y), 0.06);
  EXPECT_LT(std::abs(error.theta), 0.02);
  EXPECT_NEAR(place.sigma.head<2>().norm(), std::hypot(0.1, 0.2), 1e-9);
  // What was erased of the second map is still away, and comes back.
  const int id = b.map.edits.whole.begin()->first, joint = id + a.map.keyframes.size();
  EXPECT_EQ(map.keyframes.scan(joint)->points.size(), b.map.keyframes.scan(id)->points.size());
  ASSERT_EQ(test::edit(map, {.kind = EditCommand::kUndo, .request = {}}), "");
  EXPECT_GT(map.keyframes.scan(joint)->points.size(), b.map.keyframes.scan(id)->points.size());
}

TEST(MapMerge, RefusesTwoPlacesThatLookAlike) {
  const MappedDrive twins = test::mapped(test::twins(), test::inTwins(), 1);
  std::vector<Pose2> poses;
  for (const double y : {-0.3, 0.3}) {
    for (Pose2 pose : test::alongX(-1.6, 2.0, 0.25)) {
      pose.y = y;
      poses.push_back(pose);
    }
  }
  const MappedDrive one = test::mapped(test::twins(), poses, 2);
  const MergedMap result = test::merged(twins.map, one.map);
  EXPECT_EQ(result.report.outcome, Outcome::kAmbiguous);
  EXPECT_FALSE(result.map);
  const Pose2 apart = between(result.report.registration.T_map_second, result.report.registration.T_map_other);
  EXPECT_NEAR(std::hypot(apart.x, apart.y), test::kTwins, 0.5);
}

TEST(MapMerge, RefusesAnotherHome) {
  const MappedDrive one = test::home(1, 1), other = test::home(2, 2);
  const MergedMap result = test::merged(one.map, other.map);
  EXPECT_NE(result.report.outcome, Outcome::kMerged);
  EXPECT_FALSE(result.map);
}

TEST(MapMerge, FindsTheHomeAfterItsFurnitureWasMoved) {
  const MappedDrive one = test::home(1, 1), later = test::home(1, 2, 1);
  const MergedMap result = test::merged(one.map, later.map);
  ASSERT_EQ(result.report.outcome, Outcome::kMerged);
  EXPECT_LT(worst(*result.map, one, later), 0.08);
  EXPECT_LT(result.report.cells.share(), 0.96) << "their obstacles are not the same";
  EXPECT_GT(result.report.furniture.evidence, 2.0);
}

TEST(MapMerge, FindsTheHomeInWhichAllStayed) {
  const MappedDrive one = test::home(1, 1), later = test::home(1, 2);
  const MergedMap result = test::merged(one.map, later.map);
  ASSERT_EQ(result.report.outcome, Outcome::kMerged);
  EXPECT_GT(result.report.cells.share(), 0.99);
}

TEST(MapMerge, RefusesAnotherFloorThatLooksAlike) {
  const MappedDrive one = test::home(1, 1), upstairs = test::home(1, 2, 0, 2);
  const MergedMap result = test::merged(one.map, upstairs.map);
  EXPECT_EQ(result.report.outcome, Outcome::kOtherFurniture);
  EXPECT_LT(result.report.cells.share(), 0.95);
  EXPECT_LT(result.report.furniture.evidence, -2.0);
  EXPECT_FALSE(result.map);
  EXPECT_TRUE(test::merged(one.map, upstairs.map, true).map) << "a person takes them for one";
}

}  // namespace
}  // namespace slam::map_merge_test
