// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/decay_rate_map.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <numbers>

namespace slam::test::decay_rate_map_test {
namespace {

constexpr double kCell = 0.1;  // [m]

/// A floor plan: free from y = -2 m to a wall at 0 of a thickness in cells, 8 m long.
KeyframeGraph wallOf(int thickness) {
  auto scan = std::make_shared<StoredScan>();
  for (int column = -40; column < 40; ++column) {
    const auto x = static_cast<float>((column + 0.5) * kCell);
    for (int row = -20; row < 0; ++row) scan->free.emplace_back(x, static_cast<float>((row + 0.5) * kCell));
    const auto down = static_cast<std::int16_t>(std::lround(-0.5 * std::numbers::pi / Keyframe::Point::kAngle));
    scan->points.push_back({.x = x, .y = 0.05F, .normal = down, .normal_sigma = 100});
    for (int row = 1; row < thickness; ++row) scan->solid.emplace_back(x, static_cast<float>((row + 0.5) * kCell));
  }
  KeyframeGraph keyframes;
  keyframes.add(scan, {});
  return keyframes;
}

DecayRateMap fieldOf(const KeyframeGraph& keyframes, const BeamModel& model = {}) {
  const int all[] = {0};
  return DecayRateMap(keyframes, all, model, MapKind::kFloorPlan);
}

double through(const DecayRateMap& field, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  std::vector<DecayRateMap::Passed> passed;
  return field.pass(from, to, passed);
}

TEST(DecayRateMap, AWallStopsTheSameShareHoweverThickItWasDrawn) {
  BeamModel model;
  model.surface_layer = 0.0;
  for (const int thickness : {1, 2, 4, 6, 8}) {
    const KeyframeGraph keyframes = wallOf(thickness);
    const DecayRateMap field = fieldOf(keyframes, model);
    EXPECT_NEAR(field.walls().thickness(), thickness * kCell, 0.1 * thickness * kCell);
    const double log_through = through(field, {0.03, -1.5}, {0.03, 3.0});
    EXPECT_NEAR(log_through, model.logThrough(), 0.35 * std::abs(model.logThrough())) << thickness;
  }
}

TEST(DecayRateMap, OfAWallWithFacesTheSameShareIsLeftHoweverThickItWasDrawn) {
  for (const int thickness : {2, 4, 6, 8}) {  // one cell has no inside
    const KeyframeGraph keyframes = wallOf(thickness);
    const DecayRateMap field = fieldOf(keyframes);
    const double left = (1.0 - field.model().surface_layer) * field.model().logThrough();
    EXPECT_NEAR(through(field, {0.03, -1.5}, {0.03, 3.0}), left, 0.35 * std::abs(left)) << thickness;
  }
}

/// A corridor's wall is drawn 0.3 m thick, its true face lies anywhere in it.
TEST(DecayRateMap, ABeamAlongAWallMayCutItsFaceButNotComeThrough) {
  const KeyframeGraph keyframes = wallOf(3);
  BeamModel whole;
  whole.surface_layer = 0.0;
  const DecayRateMap field = fieldOf(keyframes), sharp = fieldOf(keyframes, whole);
  const Eigen::Vector2d from(-3.8, -0.05), within(3.8, 0.09), beyond(3.8, 0.7);
  EXPECT_EQ(through(field, from, within), 0.0);
  EXPECT_LT(through(sharp, from, within), 0.0);
  EXPECT_LT(through(field, from, beyond), 0.3 * whole.logThrough());
}

/// Two rooms, and in the wall between them a gap from x = -w/2 to w/2 [m].
KeyframeGraph roomsWithGap(double width) {
  KeyframeGraph keyframes = wallOf(2);
  auto scan = std::make_shared<StoredScan>(*keyframes.scan(0));
  const auto in_gap = [&](float x) { return std::abs(x) < 0.5 * width; };
  std::erase_if(scan->points, [&](const auto& point) { return in_gap(point.x); });
  std::erase_if(scan->solid, [&](const auto& point) { return in_gap(point.x()); });
  for (int column = -40; column < 40; ++column) {
    const auto x = static_cast<float>((column + 0.5) * kCell);
    for (int row = in_gap(x) ? 0 : 2; row < 20; ++row) {
      scan->free.emplace_back(x, static_cast<float>((row + 0.5) * kCell));
    }
  }
  KeyframeGraph rooms;
  rooms.add(scan, {});
  return rooms;
}

TEST(DecayRateMap, ADoorwayMayBeClosedAWiderGapOrARoomMayNot) {
  BeamModel model;
  const KeyframeGraph door = roomsWithGap(1.0), gate = roomsWithGap(2.5);
  const double in_free = std::log(model.rate_free);
  EXPECT_GT(fieldOf(door).logRate({0.02, 0.1}, 3.0), in_free + 1.0);
  EXPECT_EQ(through(fieldOf(door), {0.02, -1.5}, {0.02, 1.5}), 0.0);  // nor is an open one anything amiss
  EXPECT_NEAR(fieldOf(gate).logRate({0.02, 0.1}, 3.0), in_free, 0.1);
  for (const double y : {-1.0, 1.0}) EXPECT_NEAR(fieldOf(door).logRate({0.02, y}, 3.0), in_free, 0.1);
  model.doorway = 0.0;
  EXPECT_NEAR(fieldOf(door, model).logRate({0.02, 0.1}, 3.0), in_free, 0.3);
}

TEST(DecayRateMap, BeamsEndMostlyAtWallsThenWhereTheMapHasNotLookedAndSeldomInFreeSpace) {
  const KeyframeGraph keyframes = wallOf(3);
  const DecayRateMap field = fieldOf(keyframes);
  const double wall = field.logRate({0.0, 0.1}, 3.0), unknown = field.logRate({0.0, 1.8}, 3.0),
               free = field.logRate({0.0, -1.5}, 3.0);
  EXPECT_GT(wall, unknown + 1.0);
  EXPECT_NEAR(unknown, std::log(field.model().rate_unknown), 0.05);
  EXPECT_NEAR(free, std::log(field.model().rate_free), 0.05);
  EXPECT_TRUE(field.atWall(wall));
  EXPECT_FALSE(field.atWall(unknown));
  EXPECT_EQ(field.logRate({1000.0, 0.0}, 3.0), std::log(field.model().rate_unknown));  // outside the map
}

TEST(DecayRateMap, WhatTheMapHasNotLookedAtMayBeAsGoodAsAShareOfAWall) {
  BeamModel model;
  model.unknown_as_wall = 0.4;
  for (const int thickness : {1, 3}) {
    const KeyframeGraph keyframes = wallOf(thickness);
    const int all[] = {0};
    const DecayRateMap field(keyframes, all, model, MapKind::kFloorPlan);
    const double unknown = -0.4 * model.logThrough() / field.walls().thickness();
    ASSERT_GT(unknown, model.rate_unknown);
    EXPECT_NEAR(field.logRate({0.0, 1.8}, 3.0), std::log(unknown), 0.05) << thickness;
    EXPECT_NEAR(field.logRate({1000.0, 0.0}, 3.0), std::log(unknown), 1e-9) << thickness;
    EXPECT_NEAR(field.logRate({0.0, -1.5}, 3.0), std::log(model.rate_free), 0.05) << thickness;
  }
}

TEST(DecayRateMap, AWallMayGoOnBeyondTheRimOfTheMap) {
  const KeyframeGraph keyframes = wallOf(3);
  BeamModel model;
  const DecayRateMap field = fieldOf(keyframes);
  model.extrapolated_rate = 0.0;
  const DecayRateMap rim = fieldOf(keyframes, model);
  const double wall = field.logRate({0.0, 0.1}, 3.0), unknown = std::log(model.rate_unknown);
  for (const double x : {-12.0, -5.0, 5.0, 12.0}) {
    EXPECT_GT(field.logRate({x, 0.05}, 3.0), unknown + 0.5) << x;
    EXPECT_LT(field.logRate({x, 0.05}, 3.0), wall - 0.3) << x;
    EXPECT_NEAR(field.logRate({x, 1.0}, 3.0), unknown, 0.05) << x;
    EXPECT_NEAR(rim.logRate({x, 0.05}, 3.0), unknown, 0.05) << x;
    EXPECT_EQ(through(field, {x, -1.5}, {x, 3.0}), 0.0) << "nobody knows";
  }
}

TEST(DecayRateMap, AWallIsLessSharpFromAfar) {
  const KeyframeGraph keyframes = wallOf(1);
  const DecayRateMap field = fieldOf(keyframes);
  EXPECT_GT(field.logRate({0.0, 0.05}, 2.0), field.logRate({0.0, 0.05}, 45.0) + 0.3);
  EXPECT_LT(field.logRate({0.0, -0.55}, 2.0), field.logRate({0.0, -0.55}, 45.0));
}

TEST(DecayRateMap, ABeamDoesNotPassTheWallThatItEndsAtAndHardlyOneThatItGrazes) {
  const KeyframeGraph keyframes = wallOf(3);
  const DecayRateMap field = fieldOf(keyframes);
  EXPECT_EQ(through(field, {0.0, -1.5}, {0.0, 0.1}), 0.0);
  const double along = through(field, {-3.5, -0.05}, {3.5, 0.12}), across = through(field, {0.0, -1.5}, {0.5, 2.0});
  EXPECT_GT(along, 0.5 * across);  // it went a third as deep, on a way ten times as long
}

TEST(DecayRateMap, CountsEachCellOfWallOnce) {
  const KeyframeGraph keyframes = wallOf(3);
  const DecayRateMap field = fieldOf(keyframes);
  const BeamModel& model = field.model();
  std::vector<DecayRateMap::Passed> once, thrice;
  field.pass({0.03, -1.5}, {0.03, 2.0}, once);
  for (int i = 0; i < 3; ++i) field.pass({0.03, -1.5}, {0.03, 2.0}, thrice);
  const double one = field.logPassed(once);
  EXPECT_NEAR(one, model.removed_weight * model.logThrough(),
              0.4 * std::abs(model.removed_weight * model.logThrough()));
  EXPECT_EQ(field.logPassed(thrice), one);
}

/// Squares of a grid, each with a price of its own at most, made a door up to four times as dear where it lay across
/// their borders.
TEST(DecayRateMap, AnOpenDoorCostsTheSameWhereverItIs) {
  const KeyframeGraph keyframes = wallOf(3);
  const DecayRateMap field = fieldOf(keyframes);
  const auto open = [&](double from, double width) {
    std::vector<DecayRateMap::Passed> passed;
    for (double x = from; x < from + width; x += 0.25) field.pass({x, -1.5}, {x, 2.0}, passed);
    return field.logPassed(passed);
  };
  const double door = open(0.03, 0.9);
  EXPECT_LT(door, 2.0 * field.model().removed_weight * field.model().logThrough());
  for (double x = -3.47; x < 2.5; x += 0.1) EXPECT_NEAR(open(x, 0.9), door, 1e-9) << x;
  EXPECT_NEAR(open(-2.97, 1.9), 2.0 * door, 1e-9) << "a gate of twice the width";
}

TEST(DecayRateMap, OfAnEmptyMapIsEmpty) {
  const KeyframeGraph keyframes;
  const DecayRateMap field(keyframes, {});
  EXPECT_EQ(field.logRate({1.0, 2.0}, 3.0), std::log(field.model().rate_unknown));
  std::vector<DecayRateMap::Passed> passed;
  EXPECT_EQ(field.pass({0.0, 0.0}, {5.0, 0.0}, passed), 0.0);
  EXPECT_EQ(field.logPassed(passed), 0.0);
}

TEST(DecayRateMap, ABeamPassesAWallThatItEndsBehindByMoreThanItsNoise) {
  const KeyframeGraph keyframes = wallOf(2);
  BeamModel model;
  model.surface_layer = 0.0;
  const DecayRateMap field = fieldOf(keyframes, model);
  const double whole = through(field, {0.03, -1.5}, {0.03, 3.0}), behind = 2 * kCell + 0.1;  // [m] of roughness
  ASSERT_LT(whole, 0.0);
  const double noise = 2.0 * model.sigmaAt(1.5 + behind);
  EXPECT_NEAR(through(field, {0.03, -1.5}, {0.03, behind + noise + 0.05}), whole, 1e-6);
  EXPECT_GT(through(field, {0.03, -1.5}, {0.03, behind + noise - 0.15}), 0.6 * whole) << "not yet all of it";
}

}  // namespace
}  // namespace slam::test::decay_rate_map_test
