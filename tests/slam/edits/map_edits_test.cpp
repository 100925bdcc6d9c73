// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/map_edits.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "support/stored_map.hpp"

namespace slam::map_edits_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A map with edits, as the back end holds it.
class MapEditsTest : public testing::Test {
 protected:
  std::string take(EditCommand::Kind kind, EditRequest request = {}, int id = 0) {
    const Problem problem = edits.carryOut({.kind = kind, .request = std::move(request), .id = id, .utime = 5},
                                           keyframes(), in_map(), &edit);
    if (!problem) changed = eraseFrom(keyframes(), edits);
    return problem.words();
  }
  std::string erase(double x, double y, double side) {
    return take(EditCommand::kAdd, {.kind = EditKind::kErase,
                                    .name = "",
                                    .author = "test",
                                    .points = {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}}});
  }
  std::string place(const std::string& name) {
    return take(EditCommand::kAdd, {.kind = EditKind::kPlace, .name = name, .author = "", .points = {{0.0, 0.0}}});
  }
  std::vector<int> active() const {
    std::vector<int> ids;
    for (const MapEdit& one : edits.edits) {
      if (one.active) ids.push_back(one.id);
    }
    return ids;
  }
  std::size_t points() const {
    std::size_t count = 0;
    for (int id = 0; id < changing.map.keyframes.size(); ++id) count += changing.map.keyframes.scan(id)->points.size();
    return count;
  }
  KeyframeGraph& keyframes() { return changing.map.keyframes; }
  std::vector<char>& in_map() { return changing.map.in_map; }

  test::ChangingMap changing{6};
  MapEdits edits;
  int edit = 0;
  std::vector<int> changed;
};

TEST_F(MapEditsTest, ErasingTakesPointsOutOfTheKeyframesThatThereAre) {
  const std::size_t before = points();
  ASSERT_EQ(erase(-50.0, -50.0, 100.0), "");
  EXPECT_EQ(points(), 0U);
  EXPECT_EQ(changed.size(), 6U);
  changing.addKeyframe(true);
  EXPECT_THAT(eraseFrom(keyframes(), edits), IsEmpty());
  EXPECT_EQ(points(), 3U);  // what is seen later is drawn
  ASSERT_EQ(take(EditCommand::kUndo), "");
  EXPECT_EQ(points(), before + 3U);
  EXPECT_TRUE(edits.whole.empty());
}

TEST_F(MapEditsTest, UndoneErasingGivesTheSamePointsBack) {
  const MapState before = changing.copy();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 4.0);
  for (int i = 0; i < 30; ++i) ASSERT_EQ(erase(uniform(random), uniform(random), 1.0), "");
  EXPECT_LT(points(), 18U);
  for (int i = 0; i < 30; ++i) ASSERT_EQ(take(EditCommand::kUndo), "");
  EXPECT_EQ(test::differenceOf(changing.map, before), "");
}

TEST_F(MapEditsTest, ErasedPointsStayAwayHoweverTheKeyframesMove) {
  ASSERT_EQ(erase(1.0, 0.0, 1.5), "");
  std::vector<std::size_t> left;
  for (int id = 0; id < keyframes().size(); ++id) left.push_back(keyframes().scan(id)->points.size());
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  for (int round = 0; round < 50; ++round) {
    for (int id = 0; id < keyframes().size(); ++id)
      keyframes().graph().setPose(id, {uniform(random), uniform(random), uniform(random)});
    EXPECT_THAT(eraseFrom(keyframes(), edits), IsEmpty());
    for (int id = 0; id < keyframes().size(); ++id)
      EXPECT_EQ(keyframes().scan(id)->points.size(), left[static_cast<std::size_t>(id)]);
  }
  // Also when they are whole, as a stored map has them.
  for (auto& [id, scan] : edits.whole) keyframes().setScan(id, scan);
  edits.whole.clear();
  eraseFrom(keyframes(), edits);
  for (int id = 0; id < keyframes().size(); ++id)
    EXPECT_EQ(keyframes().scan(id)->points.size(), left[static_cast<std::size_t>(id)]);
}

TEST_F(MapEditsTest, KeepsTheCovarianceOfAKeyframe) {
  ASSERT_EQ(erase(-50.0, -50.0, 100.0), "");
  auto known = std::make_shared<StoredScan>(*keyframes().scan(2));
  known->covariance = Eigen::Matrix3d::Identity();
  keyframes().setScan(2, known);
  ASSERT_EQ(take(EditCommand::kUndo), "");
  EXPECT_EQ(keyframes().scan(2)->covariance, Eigen::Matrix3d::Identity());
}

TEST_F(MapEditsTest, UndoAndRedoGoThroughTheSteps) {
  EXPECT_THAT(take(EditCommand::kUndo), HasSubstr("nothing is left"));
  EXPECT_THAT(take(EditCommand::kRedo), HasSubstr("nothing was undone"));
  for (const char* name : {"dock", "kitchen", "hall"}) ASSERT_EQ(place(name), "");
  EXPECT_THAT(active(), ElementsAre(1, 2, 3));
  ASSERT_EQ(take(EditCommand::kRemove, {}, 2), "");
  EXPECT_THAT(active(), ElementsAre(1, 3));
  EXPECT_THAT(take(EditCommand::kRemove, {}, 2), HasSubstr("no edit 2"));
  EXPECT_THAT(take(EditCommand::kRemove, {}, 9), HasSubstr("no edit 9"));
  ASSERT_EQ(take(EditCommand::kUndo), "");
  EXPECT_THAT(active(), ElementsAre(1, 2, 3));
  ASSERT_EQ(take(EditCommand::kUndo), "");
  ASSERT_EQ(take(EditCommand::kUndo), "");
  EXPECT_THAT(active(), ElementsAre(1));
  ASSERT_EQ(take(EditCommand::kRedo), "");
  EXPECT_THAT(active(), ElementsAre(1, 2));
  ASSERT_EQ(place("lab"), "");  // the two steps ahead are gone
  EXPECT_THAT(active(), ElementsAre(1, 2, 4));
  EXPECT_THAT(take(EditCommand::kRedo), HasSubstr("nothing was undone"));
  EXPECT_EQ(edits.find(3), nullptr);
}

TEST_F(MapEditsTest, TheOldestStepsCannotBeUndoneForEver) {
  for (std::size_t i = 0; i < 3 * kEditLimits.steps; ++i) {
    ASSERT_EQ(place("dock"), "");
    ASSERT_EQ(take(EditCommand::kRemove, {}, edit), "");
  }
  EXPECT_EQ(edits.steps.size(), kEditLimits.steps);
  EXPECT_LE(edits.edits.size(), kEditLimits.steps);
  while (take(EditCommand::kUndo).empty()) continue;
  EXPECT_LE(active().size(), 1U);
}

TEST_F(MapEditsTest, RefusesTooManyAndAnEmptyMap) {
  for (std::size_t i = 0; i < kEditLimits.edits; ++i) ASSERT_EQ(place("dock"), "");
  EXPECT_THAT(place("dock"), HasSubstr("remove some"));
  std::fill(in_map().begin(), in_map().end(), 0);
  edits = {};
  EXPECT_THAT(place("dock"), HasSubstr("no map yet"));
}

TEST_F(MapEditsTest, ReportsWhatAnEraseWouldLeaveAroundTheRobot) {
  EditRequest all{
      .kind = EditKind::kErase, .name = "", .author = "", .points = {{-50.0, -50.0}, {50.0, -50.0}, {0.0, 50.0}}};
  EXPECT_EQ(shareLeft(*anchored(all, keyframes(), in_map()), keyframes(), {0.5, 0.0}), 0.0);
  all.points = {{20.0, 20.0}, {21.0, 20.0}, {20.0, 21.0}};
  EXPECT_EQ(shareLeft(*anchored(all, keyframes(), in_map()), keyframes(), {0.5, 0.0}), 1.0);
}

}  // namespace
}  // namespace slam::map_edits_test
