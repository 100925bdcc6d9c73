// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/place_search.hpp"

#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <numbers>

#include "support/simulated/keyframes.hpp"

namespace slam::test::place_search_test {
namespace {

using Outcome = PlaceSearch::Outcome;

/// A map of both rooms, and a session that was driven in the first.
class Searched : public MappedPlace {
 public:
  explicit Searched(const PlaceSearchConfig& config = {})
      : MappedPlace(twins(), inTwins(), 1, twins(), 2), places(config), first(keyframes.size()) {
    places.begin(keyframes, map);
    for (double s = -0.5; s <= 1.5; s += 0.25) drive(truth = {s, 0.1, 0.05});
  }
  PlaceSearch::Result search(const std::optional<PlaceWindow>& around = {}) {
    return places.search(keyframes, first, newest(), around);
  }

  PlaceSearch places;
  Pose2 truth;  ///< of the newest keyframe
  int first;
};

TEST(PlaceSearch, ChoosesBetweenAlikePlacesOnlyWhereAWindowDoes) {
  Searched searched;
  EXPECT_EQ(searched.search().outcome, Outcome::kAmbiguous);
  for (const double x : {0.0, kTwins}) {
    const Pose2 there{searched.truth.x + x, searched.truth.y, searched.truth.theta};
    searched.places.begin();
    const auto found = searched.search(PlaceWindow{there * Pose2{0.8, -0.5, 0.2}, 1.5, 0.5});
    ASSERT_EQ(found.outcome, Outcome::kFound) << x;
    const Pose2 error = between(there, found.T_map_newest);
    EXPECT_LT(std::hypot(error.x, error.y), 0.1) << x;
    EXPECT_LT(std::abs(error.theta), 0.03) << x;
  }
}

TEST(PlaceSearch, GoesOnWhereItsWorkEndedWhileTheRobotDrivesOn) {
  Searched searched;
  const PlaceWindow window{searched.truth, 1.5, 0.5};
  PlaceSearch::Result result{.outcome = Outcome::kUnfinished, .T_map_newest = {}};
  int calls = 0;
  for (; result.outcome == Outcome::kUnfinished; ++calls) {
    ASSERT_LT(calls, 1000);
    if (calls > 0) {
      EXPECT_TRUE(searched.places.underWay());
      searched.drive(searched.truth = searched.truth * Pose2{0.01, 0.0, 0.001});
    }
    std::int64_t work = 4000;
    result =
        searched.places.search(searched.keyframes, searched.first, searched.newest(), window, std::numbers::pi, &work);
  }
  EXPECT_GT(calls, 3);
  EXPECT_FALSE(searched.places.underWay());
  ASSERT_EQ(result.outcome, Outcome::kFound);
  const Pose2 error = between(searched.truth, result.T_map_newest);
  EXPECT_LT(std::hypot(error.x, error.y), 0.1) << "is where the robot is now, not where it was when asked";
  EXPECT_LT(std::abs(error.theta), 0.03);
}

TEST(PlaceSearch, TakesNoPlaceForTheOnlyOneWhereRoomForOthersWasMissing) {
  PlaceSearchConfig config;
  config.search.max_open = 50;
  Searched cut(config), whole;
  const PlaceWindow window{whole.truth, 1.5, 0.5};
  EXPECT_EQ(whole.search(window).outcome, Outcome::kFound);
  EXPECT_EQ(cut.search(window).outcome, Outcome::kAmbiguous);
}

TEST(PlaceSearch, ForgetsASearchUnderWayWithItsSession) {
  Searched searched;
  std::int64_t work = 1000;
  const auto cut = searched.places.search(searched.keyframes, searched.first, searched.newest(), {}, 3.2, &work);
  EXPECT_EQ(cut.outcome, Outcome::kUnfinished);
  searched.places.begin();
  EXPECT_FALSE(searched.places.underWay());
}

TEST(PlaceSearch, ReportsByHowMuchTheBestPlaceLeads) {
  Searched searched;
  const auto alike = searched.search();
  ASSERT_EQ(alike.outcome, Outcome::kAmbiguous);
  EXPECT_GE(alike.margin, 0.0);
  EXPECT_LT(alike.margin, 0.5 * alike.needed);
  const double x = alike.T_map_newest.x > 0.5 * kTwins ? kTwins : 0.0;
  EXPECT_NEAR(alike.T_map_newest.x, searched.truth.x + x, 0.1);
  searched.places.begin();
  const auto alone = searched.search(PlaceWindow{searched.truth, 1.5, 0.5});
  ASSERT_EQ(alone.outcome, Outcome::kFound);
  EXPECT_GE(alone.margin, alone.needed);
  EXPECT_EQ(alone.needed, PlaceSearchConfig{}.min_margin);
}

TEST(PlaceSearch, AGyroDistinguishesTheEndsOfARoomApart) {
  MappedPlace mapped(bareRoom(), alongX(-1.5, 1.5), 1, bareRoom(), 2);
  PlaceSearch places;
  places.begin(mapped.keyframes, mapped.map);
  const int first = mapped.newest() + 1;
  for (double x = 0.4; x <= 1.6; x += 0.2) mapped.drive({x, 0.3, 0.1});
  const auto search = [&](double heading_tolerance) {
    places.begin();
    return places.search(mapped.keyframes, first, mapped.newest(), {}, heading_tolerance);
  };
  EXPECT_EQ(search(std::numbers::pi).outcome, Outcome::kAmbiguous);
  const auto found = search(0.3);
  ASSERT_EQ(found.outcome, Outcome::kFound);
  EXPECT_LT(std::abs(wrapAngle(found.T_map_newest.theta - mapped.keyframes.pose(mapped.newest()).theta)), 0.3);
}

TEST(PlaceSearch, FindsNothingInAWindowBesideTheMap) {
  Searched searched;
  EXPECT_EQ(searched.search(PlaceWindow{{10.0, 30.0, 0.0}, 2.0, 0.5}).outcome, Outcome::kElsewhere);
  const Pose2& truth = searched.truth;
  EXPECT_EQ(searched.search(PlaceWindow{{truth.x, truth.y, truth.theta + 1.6}, 1.0, 0.3}).outcome, Outcome::kElsewhere)
      << "where it cannot have turned so far";
}

TEST(PlaceSearch, FindsNothingWithoutAMap) {
  Searched searched;
  EXPECT_TRUE(searched.places.hasMap());
  searched.places = PlaceSearch();
  EXPECT_FALSE(searched.places.hasMap());
  EXPECT_EQ(searched.search().outcome, Outcome::kElsewhere);
}

TEST(PlaceSearch, EvaluatesAMapByTheMeasureOfItsKind) {
  PlaceSearchConfig config;
  config.model.margin_share = 0.0;
  EXPECT_EQ(Searched().search().outcome, Outcome::kAmbiguous);
  EXPECT_EQ(Searched(config).search().outcome, Outcome::kFound);
  const auto searched = [](const PlaceSearchConfig& with) {
    Searched one(with);
    return one.search(PlaceWindow{one.truth, 1.5, 0.5});
  };
  config = {};
  config.model.margin_share = 0.5;
  EXPECT_EQ(searched(config).needed, 0.5 * PlaceSearchConfig{}.min_margin);
  config = {};
  config.model.unchanged = 3.0;  // more than all
  EXPECT_EQ(Searched(config).search().outcome, Outcome::kElsewhere);
}

TEST(PlaceSearch, AFloorPlanIsLessSharpThanScansAndOlder) {
  const PlaceModel plan = floorPlanModel(), scans = scanMapModel();
  EXPECT_GT(plan.beams.sigma, scans.beams.sigma);
  EXPECT_LT(plan.unchanged, scans.unchanged);
  EXPECT_LT(plan.margin_share, scans.margin_share);
  EXPECT_EQ(plan.kind, MapKind::kFloorPlan);
  EXPECT_EQ(scans.kind, PlaceSearchConfig{}.model.kind);
}

TEST(PlaceSearch, AcceptsALoneContenderInAWindow) {
  PlaceSearchConfig config;
  config.min_margin = 1e9;  // nobody leads by so much ...
  config.contenders = 1;    // ... but whom nobody follows; that it is in no place of the map always does
  Searched searched(config);
  EXPECT_EQ(searched.search().outcome, Outcome::kAmbiguous);
  EXPECT_EQ(searched.search(PlaceWindow{searched.truth, 1.5, 0.5}).outcome, Outcome::kFound);
}

TEST(PlaceSearch, PlacesAreOneWithinADistanceAndATurn) {
  const PlaceSearch search;
  const Pose2 place{3.0, -2.0, 3.1};
  EXPECT_TRUE(search.same(place, place * Pose2{0.74, 0.0, 0.19}));
  EXPECT_FALSE(search.same(place, place * Pose2{0.0, 0.76, 0.0}));
  EXPECT_FALSE(search.same(place, place * Pose2{0.0, 0.0, 0.21}));
  EXPECT_FALSE(search.same(place, place * Pose2{0.0, 0.0, -0.21}));
}

}  // namespace
}  // namespace slam::test::place_search_test
