// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/place_fit.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>

#include "support/simulated/keyframes.hpp"

namespace slam::test::place_fit_test {
namespace {

/// A map of keyframes along the x axis, and what a robot sees that drives there.
class Drive : public MappedPlace {
 public:
  Drive(const Place& mapped, const Place& now, double from, double to, const BeamModel& model = {})
      : MappedPlace(mapped, alongX(from, to), 1, now, 7), field(std::in_place, keyframes, map, model) {}
  /// Sees from a stretch of the path that ends at a pose.
  QueryCloud seen(const Pose2& newest_pose, double length) {
    const int first = keyframes.size();
    for (double back = length; back >= 0.0; back -= 0.25) drive(newest_pose * Pose2{-back, 0.0, 0.0});
    QueryCloud view;
    view.gather(keyframes, first, newest(), 8.0, 2.0, field->model().rigid_range);
    return view;
  }
  std::optional<DecayRateMap> field;
};

/// @param bend [rad] of what lies beyond its middle
/// @param stretch [m] by which it lies further on
Place corridorWithRecesses(double scale = 1.0, double bend = 0.0, double stretch = 0.0) {
  Place place{.name = "Recesses", .low = {-12 * scale, -2 * scale}, .high = {12 * scale, 2 * scale}};
  std::vector<Eigen::Vector2d> corners{{-12, -1.2}, {0, -1.2}, {12, -1.2}, {12, 1.2}, {9, 1.2},  {9, 1.7},
                                       {8, 1.7},    {8, 1.2},  {1, 1.2},   {1, 1.7},  {0, 1.7},  {0, 1.2},
                                       {-5, 1.2},   {-5, 1.7}, {-6, 1.7},  {-6, 1.2}, {-12, 1.2}};
  for (Eigen::Vector2d& corner : corners) {
    corner *= scale;
    if (corner.x() > 0.0) corner = Pose2{stretch, 0.0, bend} * corner;
  }
  addWalls(place.world, corners);
  return place;
}

TEST(PlaceFit, LaysASegmentWhereItIsFromAGuessThatIsOffAlongTheCorridor) {
  Drive drive(corridorWithRecesses(), corridorWithRecesses(), -10.0, 10.0);
  const Pose2 truth{2.0, 0.1, 0.05};
  const QueryCloud view = drive.seen(truth, 3.0);
  for (const double off : {-0.35, 0.0, 0.35}) {
    const PlaceFit fit = fitPlace(*drive.field, view, truth * Pose2{off, 0.05, 0.02});
    const Pose2 error = between(truth, fit.T_map_newest);
    EXPECT_LT(std::hypot(error.x, error.y), 0.15) << off;
    EXPECT_LT(std::abs(error.theta), 0.02) << off;
    EXPECT_GT(fit.seen, 0.8);
  }
}

TEST(PlaceFit, TurnsASegmentThatWasLaidAskewWhicheverWayTheRobotLooks) {
  Place across{.name = "Across", .low = {-1, -3}, .high = {1, 3}};  // longer across the way than along it
  addWalls(across.world, {{-2.2, -5}, {2.2, -5}, {2.2, 5}, {-2.2, 5}});
  across.world.add(sim::Box{-1.9, 2.0, 0.0, 0.6, 1.4});
  for (const auto& [place, reach] : {std::pair(corridorWithRecesses(), 10.0), std::pair(across, 1.5)}) {
    Drive drive(place, place, -reach, reach);
    for (const double heading : {0.1, 0.9, -2.2}) {
      const Pose2 truth{1.5, -0.4, heading};
      const QueryCloud view = drive.seen(truth, 0.0);
      for (const double turned : {-0.09, 0.09}) {  // more than moving all of it together makes good
        const PlaceFit fit = fitPlace(*drive.field, view, truth * Pose2{0.0, 0.0, turned});
        EXPECT_NEAR(wrapAngle(fit.T_map_newest.theta - heading), 0.0, 0.02) << place.name << heading << " " << turned;
      }
    }
  }
}

TEST(PlaceFit, FarWallsDistinguishOneRecessFromTheNext) {
  Drive drive(corridorWithRecesses(), corridorWithRecesses(), -10.0, 10.0);
  const Pose2 truth{0.5, 0.0, 0.0};
  const QueryCloud view = drive.seen(truth, 1.0);
  const double right = fitPlace(*drive.field, view, truth).log_likelihood;
  for (const double shift : {-6.0, 8.0}) {
    EXPECT_GT(right, fitPlace(*drive.field, view, truth * Pose2{shift, 0.0, 0.0}).log_likelihood + 10.0) << shift;
  }
}

TEST(PlaceFit, AMapThatIsLongerThanTheLidarMeasuresFitsASegmentOfItsScale) {
  constexpr double kScale = 1.02;
  Place map = corridorWithRecesses(kScale), now = corridorWithRecesses();
  map.reach = now.reach = 30.0;
  Drive drive(map, now, -10.0, 10.0);
  const Pose2 truth{-4.0, 0.0, 0.0};
  const QueryCloud view = drive.seen(truth, 3.0);
  const Pose2 in_map{kScale * truth.x, 0.0, 0.0};
  const PlaceFit as_measured = fitPlace(*drive.field, view, in_map);
  const PlaceFit scaled = fitPlace(*drive.field, view.scaled(kScale), in_map);
  EXPECT_GT(scaled.log_likelihood, as_measured.log_likelihood + 3.0);
  EXPECT_GT(scaled.log_likelihood, fitPlace(*drive.field, view.scaled(1.0 / kScale), in_map).log_likelihood + 6.0);
  EXPECT_NEAR(scaled.T_map_newest.x, in_map.x, 0.1);
}

TEST(PlaceFit, WhatIsSeenInADistanceFitsAMapThatBends) {
  BeamModel bent, straight;
  straight.rigid_range = 0.0;
  Place map = corridorWithRecesses(2.0, 0.03), now = corridorWithRecesses(2.0);
  map.reach = now.reach = 50.0;
  const Pose2 truth{-16.0, 0.0, 0.0};
  Drive with(map, now, -20.0, 20.0, bent), without(map, now, -20.0, 20.0, straight);
  const PlaceFit fit = fitPlace(*with.field, with.seen(truth, 3.0), truth),
                 rigid = fitPlace(*without.field, without.seen(truth, 3.0), truth);
  EXPECT_GT(fit.log_likelihood, rigid.log_likelihood + 4.0);
  EXPECT_GT(fit.seen, rigid.seen);
  EXPECT_LT(std::hypot(fit.T_map_newest.x - truth.x, fit.T_map_newest.y - truth.y), 0.15);
}

TEST(PlaceFit, WhatIsSeenInADistanceFitsAMapThatIsStretchedOnTheWay) {
  for (const double stretch : {0.1, 0.2}) {
    for (const double bend : {0.0, 0.03}) {
      Place map = corridorWithRecesses(2.0, bend, stretch), now = corridorWithRecesses(2.0);
      map.reach = now.reach = 50.0;
      const Pose2 truth{-16.0, 0.0, 0.0};
      Drive stretched(map, now, -20.0, 20.0), same(now, now, -20.0, 20.0);
      const double loss = fitPlace(*same.field, same.seen(truth, 3.0), truth).log_likelihood -
                          fitPlace(*stretched.field, stretched.seen(truth, 3.0), truth).log_likelihood;
      EXPECT_LT(loss, 10.0) << "stretched by " << stretch << " m, bent by " << bend;
    }
  }
}

TEST(PlaceFit, ASegmentSplitByRangeHasEachRayOnceAtItsPlace) {
  Drive drive(corridorWithRecesses(), corridorWithRecesses(), -10.0, 10.0);
  BeamModel model;
  model.rigid_range = 4.0;
  Drive split(corridorWithRecesses(), corridorWithRecesses(), -10.0, 10.0, model);
  const QueryCloud whole = drive.seen({0.0, 0.0, 0.0}, 3.0), view = split.seen({0.0, 0.0, 0.0}, 3.0);
  const auto ends = [](const QueryCloud& of) {
    std::vector<std::pair<double, double>> points;
    for (const QueryCloud::Part& part : of.parts) {
      EXPECT_LT(part.beside, &part - of.parts.data());
      for (const QueryCloud::Ray& ray : part.rays) {
        EXPECT_GE(ray.range, part.least_range);
        const Eigen::Vector2d p = part.T_newest_part * ray.to;
        points.emplace_back(p.x(), p.y());
      }
    }
    std::sort(points.begin(), points.end());
    return points;
  };
  EXPECT_GT(view.parts.size(), whole.parts.size());
  EXPECT_EQ(view.rays, whole.rays);
  const auto in_parts = ends(view), at_once = ends(whole);
  ASSERT_EQ(in_parts.size(), at_once.size());
  for (std::size_t i = 0; i < in_parts.size(); ++i) {
    EXPECT_NEAR(in_parts[i].first, at_once[i].first, 1e-9);
    EXPECT_NEAR(in_parts[i].second, at_once[i].second, 1e-9);
  }
}

/// A partition was taken away since the map was made, and things were put where it had shown free space: no worse than
/// where the map has not looked.
TEST(PlaceFit, BehindAWallThatIsGoneTheMapNoLongerReportsWhatIsFree) {
  Place map{.name = "Rooms", .low = {-4, -3}, .high = {8, 3}}, now{.name = "Hall", .low = {-4, -3}, .high = {8, 3}};
  for (Place* place : {&map, &now}) addWalls(place->world, {{-4, -3}, {8, -3}, {8, 3}, {-4, 3}});
  addWalls(map.world, {{2.0, -3.0}, {2.0, 3.0}});
  for (const double y : {-2.0, -0.7, 0.7, 2.0}) now.world.add(sim::Cylinder{4.0, y, 0.3});
  BeamModel stale_free_space, believed;
  believed.stale_free_space = false;
  for (const Pose2& pose : {Pose2{0.0, 0.0, 0.0}, Pose2{0.0, 0.0, std::numbers::pi}}) {
    Drive with(map, now, -3.0, 7.0, stale_free_space), without(map, now, -3.0, 7.0, believed);
    const double gain = fitPlace(*with.field, with.seen(pose, 0.5), pose).log_likelihood -
                        fitPlace(*without.field, without.seen(pose, 0.5), pose).log_likelihood;
    EXPECT_GT(gain, 5.0);
  }
}

/// Two rooms that are alike but for the things in one of them: where a beam that came through has a wall near its end,
/// too.
TEST(PlaceFit, ClutterDoesNotAttractBeamsThatCameThrough) {
  Place now{.name = "Room", .low = {-4, -3}, .high = {4, 3}};
  addWalls(now.world, {{-4, -3}, {4, -3}, {4, 3}, {-4, 3}});
  Place map{.name = "Rooms", .low = {-4, -3}, .high = {16, 3}, .world = now.world};
  addWalls(map.world, {{8, -3}, {16, -3}, {16, 3}, {8, 3}});
  for (double x = 8.6; x < 15.8; x += 0.9) {
    for (const double y : {-2.7, -1.4, 1.4, 2.7}) map.world.add(sim::Cylinder{x, y, 0.2});
  }
  Drive drive(map, now, -3.0, 15.0);
  const QueryCloud view = drive.seen({0.0, 0.0, 0.0}, 2.0);
  const double right = fitPlace(*drive.field, view, {0.0, 0.0, 0.0}).log_likelihood;
  for (const double x : {11.0, 12.0, 13.0}) {
    EXPECT_GT(right, fitPlace(*drive.field, view, {x, 0.0, 0.0}).log_likelihood + 5.0) << x;
  }
}

TEST(PlaceFit, OfASegmentThatSawNothingIsNone) {
  Drive drive(corridorWithRecesses(), corridorWithRecesses(), -10.0, 10.0);
  const PlaceFit fit = fitPlace(*drive.field, {}, {1.0, 2.0, 3.0});
  EXPECT_EQ(fit.log_likelihood, 0.0);
  EXPECT_EQ(fit.seen, 0.0);
  EXPECT_EQ(fit.T_map_newest.x, 1.0);
}

}  // namespace
}  // namespace slam::test::place_fit_test
