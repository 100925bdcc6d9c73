// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_builder.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "support/simulated/keyframes.hpp"
#include "support/stored_map.hpp"

namespace slam::map_builder_test {
namespace {

using test::onRing;
using testing::HasSubstr;

const Eigen::Vector3d kDrift(0.01, 0.01, 0.002);  // [m, m, rad] a step
constexpr double kStep = 0.5, kRound = 40.0;      // [m]

TEST(MapBuilder, NamesWhatEachKeyframeChanged) {
  test::KeyframeDrive drive(test::ringCorridor());
  MapBuilder builder({});
  std::vector<Pose2> poses;
  int closed = 0, drawn = 0;
  for (double s = 0.0; s < 1.2 * kRound; s += kStep) {
    const int generation = builder.backEnd().generation();
    MapUpdate update = builder.add(drive.at(onRing(s), kDrift));
    drawn += static_cast<int>(update.scans.size());
    EXPECT_EQ(update.poses.empty(), builder.backEnd().generation() == generation);
    if (!update.poses.empty()) {
      const auto now = builder.backEnd().keyframes().graph().poses();
      EXPECT_TRUE(std::equal(update.poses.begin(), update.poses.end(), now.begin(), now.end()));
    }
    closed += update.loop_closed ? 1 : 0;
    EXPECT_FALSE(update.relocalised || update.begun_anew);
    EXPECT_EQ(update.first_in_map, 0);
    if (update.correction) builder.recycle(std::move(update.correction));
  }
  EXPECT_GT(closed, 0);
  EXPECT_EQ(drawn, builder.backEnd().keyframes().size());
}

TEST(MapBuilder, MakesNoCorrectionBeforeTheLastOneIsGivenBack) {
  test::KeyframeDrive drive(test::ringCorridor());
  MapBuilder builder({});
  std::unique_ptr<MapCorrection> away;
  double s = 0.0;
  for (; s < 1.2 * kRound && !away; s += kStep) away = builder.add(drive.at(onRing(s), kDrift)).correction;
  ASSERT_TRUE(away);
  const double first = s;
  for (; s < first + kRound; s += kStep) EXPECT_EQ(builder.add(drive.at(onRing(s), kDrift)).correction, nullptr) << s;
  builder.recycle(std::move(away));
  for (; s < first + 2.0 * kRound && !away; s += kStep) away = builder.add(drive.at(onRing(s), kDrift)).correction;
  EXPECT_TRUE(away);
}

TEST(MapBuilder, GoesOnInTheStateThatItGave) {
  test::KeyframeDrive drive(test::ringCorridor());
  MapBuilder first({});
  for (double s = 0.0; s < 10.0; s += kStep) first.add(drive.at(onRing(s), kDrift));
  const MapState state = first.state({OccupancyGrid(OccupancyGridConfig{}), {}}, 5);
  EXPECT_EQ(state.keyframes.size(), 20);
  EXPECT_EQ(state.grid_keyframes, 5);
  const MapBuilder next({}, state);
  ASSERT_EQ(next.backEnd().keyframes().size(), 20);
  for (int id = 0; id < 20; ++id) {
    EXPECT_EQ(next.backEnd().keyframes().pose(id), first.backEnd().keyframes().pose(id));
    EXPECT_TRUE(next.backEnd().map().inMap(id));
  }
}

/// A robot in a ring of corridors, with its map drawn.
class EditsInMap : public testing::Test {
 protected:
  void drive(double from, double to, const Eigen::Vector3d& drift = kDrift) {
    for (double s = from; s < to; s += kStep) {
      MapUpdate update = builder.add(course.at(onRing(s), drift));
      for (const MapScan& scan : update.scans) mapper.add(scan);
      if (!update.poses.empty()) mapper.move(update.poses);
      if (update.edits) mapper.apply(*update.edits);
      closed += update.loop_closed ? 1 : 0;
      if (update.correction) {
        ++corrections;
        builder.recycle(std::move(update.correction));
      }
    }
    mapper.work(std::numeric_limits<int>::max());
  }
  EditOutcome edit(const EditCommand& command) {
    const auto& keyframes = builder.backEnd().keyframes();
    EditOutcome outcome = builder.edit(command, keyframes.pose(keyframes.size() - 1).translation());
    for (const MapScan& scan : outcome.scans) mapper.add(scan);
    if (!outcome.problem) mapper.apply(outcome.drawing, outcome.anew);
    mapper.work(std::numeric_limits<int>::max());
    return outcome;
  }
  /// A square of 1 m about a point that the first keyframe sees.
  EditCommand aboutAWall(EditKind kind) const {
    const auto& keyframes = builder.backEnd().keyframes();
    const Keyframe::Point& point = keyframes.scan(0)->points.front();
    const Eigen::Vector2d wall = keyframes.pose(0) * Eigen::Vector2d(point.x, point.y);
    return test::squareEdit(kind, wall.x() - 0.5, wall.y() - 0.5);
  }
  /// Cells drawn as occupied in the middle of an outline [m, in map].
  int occupiedIn(const Outline& outline) const {
    const Bounds bounds = Bounds::of(outline);
    int count = 0;
    for (double x = bounds.low.x() + 0.1; x < bounds.high.x() - 0.1; x += 0.05) {
      for (double y = bounds.low.y() + 0.1; y < bounds.high.y() - 0.1; y += 0.05)
        count += mapper.grid().logOdds(mapper.grid().cellAt({x, y})) > 0 ? 1 : 0;
    }
    return count;
  }
  Outline whereIs(int id) const {
    const KeyframeMap& map = builder.backEnd().map();
    for (const MapEdit& one : map.edits.edits) {
      if (one.id == id) return pointsOf(one, map.keyframes, map.in_map);
    }
    return {};
  }

  test::KeyframeDrive course{test::ringCorridor()};
  MapBuilder builder{BackEndConfig{}};
  Mapper mapper;
  int closed = 0, corrections = 0;
};

TEST_F(EditsInMap, AnEraseLeavesKeyframesDrawingAndReferenceUntilItIsSeenAgain) {
  drive(0.0, 6.0);
  const EditCommand erase = aboutAWall(EditKind::kErase);
  ASSERT_GT(occupiedIn(erase.request.points), 0);
  const EditOutcome outcome = edit(erase);
  ASSERT_EQ(outcome.problem.words(), "");
  EXPECT_FALSE(outcome.scans.empty());
  EXPECT_EQ(occupiedIn(erase.request.points), 0);
  const int before = corrections;
  drive(6.0, 7.0);
  EXPECT_GT(corrections, before) << "the reference follows";
  EditCommand undo;
  undo.kind = EditCommand::kUndo;
  ASSERT_EQ(edit(undo).problem.words(), "");
  EXPECT_GT(occupiedIn(erase.request.points), 0);
}

TEST_F(EditsInMap, FreeStaysFreeWhateverIsSeenAndHoweverTheMapMoves) {
  drive(0.0, 6.0);
  const EditOutcome outcome = edit(aboutAWall(EditKind::kFree));
  ASSERT_EQ(outcome.problem.words(), "");
  EXPECT_EQ(occupiedIn(whereIs(1)), 0);
  drive(6.0, 1.3 * kRound);
  ASSERT_GT(closed, 0);
  EXPECT_EQ(occupiedIn(whereIs(1)), 0);
}

TEST_F(EditsInMap, RefusesWhatWouldLoseTheRobotUnlessItIsForced) {
  drive(0.0, 6.0);
  EditCommand all = test::squareEdit(EditKind::kErase, 0.0, 0.0);
  all.request.points = {{-40.0, -40.0}, {40.0, -40.0}, {40.0, 40.0}, {-40.0, 40.0}};
  EXPECT_THAT(edit(all).problem.words(), HasSubstr("would get lost"));
  all.request.force = true;
  EXPECT_EQ(edit(all).problem.words(), "");
}

TEST_F(EditsInMap, AreThereTheNextDay) {
  drive(0.0, 6.0);
  ASSERT_EQ(edit(aboutAWall(EditKind::kErase)).problem.words(), "");
  ASSERT_EQ(edit(aboutAWall(EditKind::kFree)).problem.words(), "");
  const MapState state = builder.state({mapper.grid().clone(), {}}, builder.backEnd().keyframes().size());
  EXPECT_EQ(state.edits.edits.size(), 2U);
  MapBuilder next({}, state);
  EditCommand undo;
  undo.kind = EditCommand::kUndo;
  EXPECT_EQ(next.edit(undo, {}).problem.words(), "");
  const EditOutcome outcome = next.edit(undo, {});
  EXPECT_FALSE(outcome.scans.empty()) << "the points come back";
}

TEST_F(EditsInMap, WithoutAMapNothingIsEdited) {
  EXPECT_THAT(builder.edit(test::squareEdit(EditKind::kFree, 0.0, 0.0), {}).problem.words(), HasSubstr("no map yet"));
}

}  // namespace
}  // namespace slam::map_builder_test
