// SPDX-License-Identifier: BSD-3-Clause
// What the front end believes once its prediction has led nowhere, and what it takes for being carried away.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "frontend/place_drive.hpp"

namespace slam::find_test {
namespace {

using test::Place;
using test::PlaceDrive;

const Eigen::Vector3d kStand(0, 0, 0);

/// A hall of 8 m by 5 m, told from its mirror image by two cupboards. @param partition a wall across most of it
/// @param boxes as many crates, each before another piece of wall
Place hall(bool partition, int boxes = 0) {
  Place place{.name = "Hall", .low = {-3, -2}, .high = {3, 2}};
  test::addWalls(place.world, {{-4, -2.5}, {4, -2.5}, {4, 2.5}, {-4, 2.5}});
  place.world.add(sim::Box{-3.6, 1.9, 0.0, 0.8, 1.2});
  place.world.add(sim::Box{3.2, -2.3, 0.0, 1.6, 0.4});
  if (partition) place.world.add(sim::Box{1.2, -0.6, 0.0, 0.2, 3.0});
  for (int i = 0; i < boxes; ++i) place.world.add(sim::Box{-2.6 + 0.9 * i, -1.7, 0.0, 0.45, 0.3});
  return place;
}

/// Somewhere else altogether: four bare walls.
Place elsewhere(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  Place place{.name = "Elsewhere", .low = low, .high = high};
  test::addWalls(place.world, {low, {high.x(), low.y()}, high, {low.x(), high.y()}});
  return place;
}

/// The robot learns a hall, driving to and fro, and is then lifted somewhere else in it, which the wheels do not see.
PlaceDrive liftedIn(const Place& place, const FrontEndConfig& config = {}) {
  PlaceDrive drive(place, config);
  drive.gyro.there = false;  // it would tell the turn
  drive.truth = {-1.0, 1.0, 0.0};
  drive.run(1.0, kStand);
  for (int i = 0; i < 4; ++i) drive.run(10.0, {i % 2 == 0 ? 0.3 : -0.3, 0, 0});  // 3 m: it sees both sides
  EXPECT_TRUE(drive.last.fused);
  drive.truth = drive.truth * Pose2{0.4, -0.45, 0.7};  // no further than a robot gets from scan to scan
  return drive;
}
/// Of the pose, whose map begins where the robot did [m].
double error(const PlaceDrive& drive) {
  const Pose2 truth = Pose2{-1.0, 1.0, 0.0}.inverse() * drive.truth;
  return (drive.front_end->estimate(drive.now).T_map_base.translation() - truth.translation()).norm();
}

TEST(Find, IsNotAcceptedWhereTheScanSeesThroughAWallThatIsKnown) {
  for (const bool removed : {false, true}) {
    PlaceDrive drive = liftedIn(hall(true));
    if (removed) drive.enter(hall(false));
    drive.run(0.8, kStand);
    EXPECT_EQ(drive.last.fused, !removed);
    if (!removed) {
      EXPECT_LT(error(drive), 0.05);
    }
  }
}

TEST(Find, ThatFitsMuchWorseIsAcceptedOnlyWhereARobotGetsFromScanToScan) {
  for (const auto& [much_worse, rotation, believed] :
       {std::tuple(0.12, 0.8, true), std::tuple(0.12, 0.6, false), std::tuple(0.5, 0.6, true)}) {
    FrontEndConfig config;
    config.validator.much_worse = much_worse;
    config.search_window.rotation = rotation;
    PlaceDrive drive = liftedIn(hall(false), config);
    drive.enter(hall(false, 5));
    drive.run(0.8, kStand);
    EXPECT_EQ(drive.last.fused, believed) << much_worse << " " << rotation << ", overlap " << drive.last.match.overlap;
  }
}

TEST(Find, NeedsTheOverlapThatIsAskedFor) {
  for (const auto& [trusted, believed] : {std::pair(0.7, true), std::pair(1.01, false)}) {
    FrontEndConfig config;
    config.validator.trusted_overlap = trusted;
    PlaceDrive drive = liftedIn(hall(false), config);
    drive.run(0.8, kStand);
    EXPECT_EQ(drive.last.fused, believed);
  }
}

TEST(Find, IsWhatAMatchMustBeOnceTheWayIsLost) {
  FrontEndConfig config;
  config.validator.trusted_overlap = 1.01;  // nothing is ever found here
  PlaceDrive drive(hall(false), config);
  drive.truth = {-1.0, 1.0, 0.0};
  drive.run(4.0, kStand);
  EXPECT_TRUE(drive.last.fused) << "as long as the way is not lost";
  drive.enter(elsewhere({-2.0, 0.2}, {0.3, 1.7}));
  drive.run(0.2, kStand);
  ASSERT_FALSE(drive.last.fused);
  drive.enter(hall(false, 3));
  drive.run(0.4, kStand);
  EXPECT_FALSE(drive.last.fused) << drive.last.match.overlap;
  drive.enter(hall(false));
  drive.run(0.4, kStand);
  EXPECT_TRUE(drive.last.fused) << "it fits as well as before";
}

/// Scans match no longer while the wheels tell this motion. @return whether the robot takes itself for carried away
bool kidnapped(const Place& next, const Eigen::Vector3d& motion, FrontEndConfig config = {}) {
  config.validator.trusted_overlap = 1.01;  // nor is anything found
  PlaceDrive drive(hall(false), config);
  drive.truth = {-2.5, 0.5, 0.0};
  drive.run(4.0, kStand);
  EXPECT_TRUE(drive.last.fused);
  drive.enter(next);
  const auto keyframes = drive.front_end->counters().keyframes;
  // It takes nine scans and more than a second until it decides: 1.8 s.
  for (int i = 0; i < 20 && drive.front_end->counters().lost == 0; ++i) {
    if (drive.front_end->counters().keyframes != keyframes) return false;
    drive.run(0.2, motion / 1.8);
    EXPECT_FALSE(drive.last.fused);
  }
  return drive.front_end->counters().lost > 0;
}

TEST(CarriedAway, IsARobotThatSeesThroughWallsWhateverItsWheelsReport) {
  const Place open = elsewhere({-7.0, -5.0}, {6.0, 6.0});
  for (const Eigen::Vector3d& motion : {kStand, Eigen::Vector3d(1.15, 0, 0), Eigen::Vector3d(0, 0, 1.7)}) {
    EXPECT_TRUE(kidnapped(open, motion)) << motion.transpose();
  }
  FrontEndConfig config;
  config.validator.free_space_violation = 1.0;
  EXPECT_FALSE(kidnapped(open, {1.15, 0, 0}, config));
  config.localise_only = true;
  EXPECT_TRUE(kidnapped(open, {1.15, 0, 0}, config)) << "in a given map there is nothing else to know";
  config.localise_only = false;
  config.tracking.lost_position_sigma = 0.01;
  EXPECT_TRUE(kidnapped(open, {1.15, 0, 0}, config)) << "the wheels' way is too uncertain";
}

TEST(CarriedAway, IsNoRobotBehindABoxThatHidesItsWalls) {
  EXPECT_FALSE(kidnapped(elsewhere({-3.3, -0.2}, {-1.3, 1.1}), kStand));
}

TEST(CarriedAway, IsDecidedAfterSoManyScansAndSoLong) {
  const auto decidedAfter = [](int failures, double degraded) {
    FrontEndConfig config;
    config.validator.trusted_overlap = 1.01;
    config.tracking.max_failures = failures;
    config.tracking.degraded_after = degraded;
    PlaceDrive drive(hall(false), config);
    drive.truth = {-2.5, 0.5, 0.0};
    drive.run(2.0, kStand);
    drive.enter(elsewhere({-7.0, -5.0}, {6.0, 6.0}));
    int scans = 0;
    while (drive.front_end->counters().lost == 0 && scans < 100) {
      drive.run(0.2, kStand);
      ++scans;
    }
    return scans;
  };
  EXPECT_EQ(decidedAfter(8, 1.0), 9);
  EXPECT_EQ(decidedAfter(3, 0.1), 4);
  EXPECT_EQ(decidedAfter(3, 3.0), 15);
}

TEST(State, IsDegradedAfterItsTimeAndLostByItsSigma) {
  const auto standing = [](const FrontEndConfig& config) {
    PlaceDrive drive(hall(false), config);
    drive.run(2.0, kStand);
    return drive;
  };
  FrontEndConfig config;
  config.tracking.degraded_after = 0.7;
  const PlaceDrive drive = standing(config);
  const auto after = [](const PlaceDrive& d, double seconds) {
    return d.front_end->estimate(d.now + fromSeconds(seconds));
  };
  EXPECT_EQ(after(drive, 0.69).state, LocalisationState::kLocalised);
  EXPECT_EQ(after(drive, 0.71).state, LocalisationState::kDegraded);
  const Eigen::Matrix3d P = after(drive, 0.5).covariance;
  const double sigma = std::sqrt(std::max(P(0, 0), P(1, 1)));
  config.tracking.lost_position_sigma = 1.01 * sigma;
  EXPECT_EQ(after(standing(config), 0.5).state, LocalisationState::kLocalised);
  config.tracking.lost_position_sigma = 0.99 * sigma;
  EXPECT_EQ(after(standing(config), 0.5).state, LocalisationState::kLost);
}

TEST(State, IsDegradedByOneScanThatMatchesNothing) {
  PlaceDrive drive(hall(false));
  drive.run(2.0, kStand);
  EXPECT_EQ(drive.front_end->estimate(drive.now).state, LocalisationState::kLocalised);
  drive.enter(elsewhere({-7.0, -5.0}, {6.0, 6.0}));
  drive.run(0.2, kStand);
  ASSERT_FALSE(drive.last.fused);
  EXPECT_EQ(drive.front_end->estimate(drive.now).state, LocalisationState::kDegraded);
}

TEST(DepthViews, AreDrawnAfterADistanceOrATurnOrATime) {
  const auto drawn = [](const Eigen::Vector3d& motion, double period) {
    FrontEndConfig config;
    config.depth.period = period;
    PlaceDrive drive(hall(false), config);
    drive.run(2.0, kStand);
    auto laser = std::make_unique<PseudoLaser>();
    laser->stamp = drive.now;
    EXPECT_NE(drive.front_end->add(*laser), nullptr);
    drive.run(1.0, motion);
    laser->stamp = drive.now;
    return drive.front_end->add(*laser) != nullptr;
  };
  EXPECT_FALSE(drawn(kStand, 1.5));
  EXPECT_TRUE(drawn(kStand, 0.9));
  EXPECT_FALSE(drawn({0.04, 0, 0}, 1e3));
  EXPECT_TRUE(drawn({0.06, 0, 0}, 1e3));
  EXPECT_FALSE(drawn({0, 0, 0.04}, 1e3));
  EXPECT_TRUE(drawn({0, 0, -0.06}, 1e3));
}

TEST(Lifted, IsARobotWhosePlaceIsNotValidUntilAScanFitsWhereItWas) {
  PlaceDrive drive(hall(false));
  drive.truth = {-2.5, 0.5, 0.0};
  drive.run(4.0, kStand);
  ASSERT_EQ(drive.state(), LocalisationState::kLocalised);
  const auto keyframes = drive.front_end->counters().keyframes;
  const double before = drive.error();  // the map begins where the robot stood first
  drive.lifted = true;
  for (int i = 0; i < 30; ++i) {
    drive.run(0.2, kStand);
    EXPECT_EQ(drive.state(), LocalisationState::kLost);
    EXPECT_FALSE(drive.last.fused);
    EXPECT_EQ(drive.last.keyframe, nullptr);
  }
  drive.lifted = false;
  drive.run(0.5, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised) << "it was put down where it had been";
  EXPECT_NEAR(drive.error(), before, 0.02);
  EXPECT_EQ(drive.front_end->counters().keyframes, keyframes);
  EXPECT_EQ(drive.front_end->counters().lost, 0U);
}

TEST(Lifted, IsCarriedAwayWhereItsScansFitNoLonger) {
  for (const double seconds : {0.6, 5.0}) {
    PlaceDrive drive(hall(false));
    drive.truth = {-2.5, 0.5, 0.0};
    drive.run(4.0, kStand);
    const std::size_t kept = drive.kept.size();
    drive.lifted = true;
    drive.enter(elsewhere({-7.0, -5.0}, {6.0, 6.0}));
    drive.run(seconds, kStand);
    EXPECT_EQ(drive.kept.size(), kept) << "nothing is mapped from somebody's arms";
    EXPECT_EQ(drive.front_end->counters().lost, 0U);
    drive.lifted = false;
    for (int i = 0; i < 20 && drive.front_end->counters().lost == 0; ++i) {
      drive.run(0.2, kStand);
      EXPECT_EQ(drive.kept.size(), kept) << "nor at the place where it was";
    }
    EXPECT_EQ(drive.front_end->counters().lost, 1U) << "a session of its own, which the back end finds";
  }
}

}  // namespace
}  // namespace slam::find_test
