// SPDX-License-Identifier: BSD-3-Clause
#include "slam/refine/map_refinement.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/simulated/mapped_drive.hpp"

namespace slam {
namespace {

using Outcome = RefineReport::Outcome;
using test::MappedDrive;

/// Two laps of a corridor without a closure: the second one has drifted.
MappedDrive twoLaps(unsigned seed, double length = 90.0) {
  return test::mapped(test::ringCorridor(), test::alongRing(0.0, length), seed);
}

RefinedMap refined(const MapState& map) { return refineMap(map, BackEndConfig{}, test::smallGrid()); }

/// [m] RMS error of the keyframes relative to the first one.
double errorOf(const MapState& map, const std::vector<Pose2>& truth) {
  double squares = 0.0;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    const Pose2 error = between(between(truth.front(), truth[static_cast<std::size_t>(id)]),
                                between(map.keyframes.pose(0), map.keyframes.pose(id)));
    squares += error.translation().squaredNorm();
  }
  return std::sqrt(squares / map.keyframes.size());
}

TEST(MapRefinement, JoinsTheVisitsToAPlace) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const MappedDrive drive = twoLaps(seed);
    const RefinedMap result = refined(drive.map);
    ASSERT_EQ(result.report.outcome, Outcome::kRefined) << seed;
    EXPECT_LT(result.report.after.held_back, 0.5 * result.report.before.held_back) << seed;
    EXPECT_LE(result.report.after.wall_thickness, result.report.before.wall_thickness) << seed;
    EXPECT_LT(errorOf(*result.map, drive.truth), errorOf(drive.map, drive.truth)) << seed;
    EXPECT_TRUE(test::sameCells(result.map->grid, test::drawn(*result.map)));
  }
}

TEST(MapRefinement, KeepsEditsWithTheKeyframesThatTheyAreTiedTo) {
  MappedDrive drive = twoLaps(1);
  EditRequest dock;
  dock.kind = EditKind::kPlace;
  dock.name = "dock";
  dock.points = {drive.map.keyframes.pose(20).translation()};
  int edit = 0;
  ASSERT_FALSE(drive.map.edits.carryOut({.kind = EditCommand::kAdd, .request = dock, .utime = 1}, drive.map.keyframes,
                                        drive.map.in_map, &edit));
  const RefinedMap result = refined(drive.map);
  ASSERT_TRUE(result.map);
  ASSERT_EQ(result.map->edits.edits.size(), 1u);
  EXPECT_EQ(result.map->edits.edits[0].name, "dock");
  const Pose2 last = between(drive.map.keyframes.pose(drive.map.keyframes.size() - 1), drive.map.T_map_base);
  const Pose2 now = between(result.map->keyframes.pose(result.map->keyframes.size() - 1), result.map->T_map_base);
  EXPECT_NEAR((last.translation() - now.translation()).norm(), 0.0, 1e-9) << "the robot stays at its keyframe";
}

TEST(MapRefinement, KeepsAMapThatIsRefinedAlready) {
  const RefinedMap once = refined(twoLaps(1).map);
  ASSERT_TRUE(once.map);
  const RefinedMap again = refined(*once.map);
  EXPECT_LE(again.report.after.held_back, 1.1 * once.report.after.held_back);
  const auto edges = once.map->keyframes.graph().edges().size();
  EXPECT_LE(again.map ? again.map->keyframes.graph().edges().size() : edges, edges + edges / 10)
      << "a tie takes the place of the one of the same visits";
}

TEST(MapRefinement, HasNothingToDoWithoutRevisits) {
  EXPECT_EQ(refined(twoLaps(1, 10.0).map).report.outcome, Outcome::kNoRevisits);
  EXPECT_EQ(refined(twoLaps(1, 0.0).map).report.outcome, Outcome::kNoKeyframes);
  EXPECT_EQ(refined(MapState()).report.outcome, Outcome::kNoKeyframes);
  MappedDrive plan = twoLaps(1, 10.0);
  plan.map.kind = MapKind::kFloorPlan;
  EXPECT_EQ(refined(plan.map).report.outcome, Outcome::kFloorPlan);
}

TEST(MapRefinement, ShowsProgressThatNeverFalls) {
  double last = 0.0;
  refineMap(twoLaps(1).map, BackEndConfig{}, test::smallGrid(), {}, [&](double share) {
    EXPECT_GE(share, last);
    last = share;
  });
  EXPECT_DOUBLE_EQ(last, 1.0);
}

}  // namespace
}  // namespace slam
