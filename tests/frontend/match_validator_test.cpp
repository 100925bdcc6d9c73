// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/match_validator.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "frontend/drive.hpp"
#include "support/allocations.hpp"

namespace slam::match_validator_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

/// Where a beam meets a person's legs, or as far as it went without the person.
float behind(const Pose2& lidar, const Beam& beam, const Eigen::Vector2d& person) {
  constexpr double kRadius = 0.2;  // [m]
  const double bearing = lidar.theta + beam.bearing;
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing)), to = person - lidar.translation();
  const double along = to.dot(direction), inside = kRadius * kRadius - (to.squaredNorm() - along * along);
  if (along <= 0.0 || inside <= 0.0) return beam.range;
  const double range = along - std::sqrt(inside);
  return beam.range > 0.0F && beam.range < range ? beam.range : static_cast<float>(range);
}

MatchValidator validatorOf(const FrontEndConfig& config) {
  return {config.validator, config.dynamic_object_gate, config.search_window, config.lidar.T_base_lidar.translation()};
}

TEST(MatchValidator, IsSeldomPulledAlongACorridorByWhoWalksThere) {
  for (const double pace : {-1.2, 0.3}) {  // [m/s]
    int pulled = 0, blamed = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      Drive drive;
      drive.random.seed(seed);
      drive.enter(test::Room{.length = 80.0, .width = 2.0, .reach = 8.0});
      Eigen::Vector2d person(1.5, 0.4);
      drive.rearrange = [&](LaserScan& scan) {
        person.x() += 0.18 * pace;
        if (std::abs(person.x() - drive.truth.x) > 4.0) person.x() = drive.truth.x - std::copysign(3.0, pace);
        for (int i = 0; i < scan.size; ++i) {
          Beam& beam = scan.storage[static_cast<std::size_t>(i)];
          beam.range = behind(drive.truth, beam, person);
        }
      };
      drive.run(2.0, kStand);
      drive.run(40.0, {0.3, 0, 0});
      pulled += drive.error() > 1.2;
      EXPECT_GT(drive.front_end->counters().scans_held, 10U) << pace << "; in most of them the person is left out";
      blamed += drive.front_end->counters().wheels_rejected > 0;
    }
    EXPECT_LE(pulled, pace > 0.0 ? 3 : 0) << pace << "; by 12 m and more, and of 10 all, if each match is believed";
    EXPECT_LE(blamed, pace > 0.0 ? 2 : 0) << pace << "; the wheels are right";
  }
}

TEST(MatchValidator, AcceptsNoPlaceThatAGyroContradicts) {
  const FrontEndConfig config;
  MatchValidator validator = validatorOf(config);
  const LocalMap local_map(config.reference, config.lidar.T_base_lidar);
  const TrackingState tracking(config.tracking, false, false);
  for (const bool gyro : {true, false}) {
    EkfTimeline filter(config.ekf, config.timeline);
    Timestamp now{std::chrono::seconds(100)};
    for (int i = 0; i < 100; ++i, now += std::chrono::milliseconds(20)) {
      filter.add(WheelSample{now, {}});
      if (gyro) filter.add(ImuSample{now, {0, 0, 0.0}, {0, 0, 9.81}});
    }
    const Ekf predicted = filter.at(filter.newestStamp());
    ASSERT_EQ(predicted.gyroActive(), gyro);
    MatchResult found;
    found.status = MatchStatus::kConverged;
    found.overlap = 0.95;
    const auto accepted = [&](double degrees) {
      found.T_ref_base.theta = degrees * std::numbers::pi / 180.0;
      return validator.acceptSearch(found, {}, local_map, predicted, tracking);
    };
    EXPECT_TRUE(accepted(3.0));
    EXPECT_EQ(accepted(30.0), !gyro) << "a look-alike, seen with the robot turned";
    EXPECT_EQ(accepted(-30.0), !gyro);
  }
}

TEST(MatchValidator, AcceptsNoWorseMatchBehindAGapOfARobotThatStood) {
  const FrontEndConfig config;
  MatchValidator validator = validatorOf(config);
  const LocalMap local_map(config.reference, config.lidar.T_base_lidar);
  TrackingState tracking(config.tracking, false, false);
  MatchResult match;
  match.status = MatchStatus::kConverged;
  match.observable = 3;
  const Timestamp begin{100s};
  match.overlap = 0.98;
  tracking.begin(begin, {}, {});
  tracking.follow(match, begin, {}, {});
  const auto accepted = [&](double overlap, Duration later, double moved) {
    Cloud cloud;
    cloud.stamp = begin + later;
    match.overlap = overlap;
    match.T_ref_base.x = moved;
    return validator.acceptTracking(match, cloud, local_map, Ekf(config.ekf, cloud.stamp, {moved, 0, 0}), tracking);
  };
  EXPECT_TRUE(accepted(0.64, 200ms, 0.0)) << "half of the view is new";
  EXPECT_FALSE(accepted(0.64, 3s, 0.0)) << "carried with a covered lidar";
  EXPECT_TRUE(accepted(0.98, 3s, 0.0)) << "it stood where it was";
  EXPECT_TRUE(accepted(0.64, 3s, 1.0)) << "it drove on";
}

TEST(MatchValidator, AcceptsACorridorsEndWhereAWheelSlips) {
  for (const double side : {-1.0, 1.0}) {
    Drive drive;
    drive.gyro.there = false;
    drive.enter(test::Room{.length = 30.0, .width = 2.0, .reach = 20.0});
    drive.run(2.0, kStand);
    drive.run(6.0, {0.3, 0, 0});
    const std::uint32_t held = drive.front_end->counters().scans_held;
    for (int i = 0; i < 6; ++i) {
      drive.run(3.0, {0.3, 0, 0});
      drive.wheels.leap({0.12, 0.0, 0.08 * side});
      drive.run(0.2, {0.3, 0, 0});
      EXPECT_LT(drive.error(), 0.1) << "after slip " << i;
    }
    EXPECT_EQ(drive.front_end->counters().scans_held, held);
  }
}

/// [s] after which walls in the open tell that the robot was carried; -1: they did not within 6 s.
double toldAfter(const VisibilityTally& walls, double interrupted_at = -1.0) {
  MatchValidator validator = validatorOf({});
  Cloud cloud;
  for (int i = 0; i <= 30; ++i) {
    cloud.stamp = Timestamp(fromSeconds(0.2 * i));
    cloud.walls = 0.2 * i == interrupted_at ? VisibilityTally{200, 0} : walls;
    if (validator.wallsInTheOpen(cloud)) return 0.2 * i;
  }
  return -1.0;
}

TEST(MatchValidator, TakesWallsThatStandInTheOpenForSecondsForARobotThatWasCarried) {
  EXPECT_NEAR(toldAfter({.consistent = 50, .violated = 50}), 3.0, 0.01);
  EXPECT_NEAR(toldAfter({.consistent = 50, .violated = 50}, 2.0), 5.2, 0.01) << "in a row";
  EXPECT_EQ(toldAfter({.consistent = 70, .violated = 30}), -1.0) << "what moves may hide much";
  EXPECT_EQ(toldAfter({.consistent = 5, .violated = 10}), -1.0) << "too few tell";
}

TEST(MatchValidator, AcceptsATurnOfThreeStandardDeviationsBeyondTheGyrosError) {
  const FrontEndConfig config;
  MatchValidator validator = validatorOf(config);
  const LocalMap local_map(config.reference, config.lidar.T_base_lidar);
  const TrackingState tracking(config.tracking, false, false);
  EkfTimeline filter(config.ekf, config.timeline);
  Timestamp now{std::chrono::seconds(100)};
  for (int i = 0; i < 100; ++i, now += std::chrono::milliseconds(20)) {
    filter.add(WheelSample{now, {}});
    filter.add(ImuSample{now, {0, 0, 0.0}, {0, 0, 9.81}});
  }
  filter.setPose({}, {0.1, 0.1, 0.05});
  const Ekf predicted = filter.at(filter.newestStamp());
  const double sigma = std::sqrt(predicted.covariance()(2, 2));
  ASSERT_NEAR(sigma, 0.05, 0.005);
  for (const double side : {-1.0, 1.0}) {
    for (const auto& [sigmas, believed] : {std::pair(2.8, true), std::pair(3.2, false)}) {
      MatchResult found;
      found.status = MatchStatus::kConverged;
      found.overlap = 0.95;
      found.T_ref_base.theta = side * (config.validator.gyro_error + sigmas * sigma);
      EXPECT_EQ(validator.acceptSearch(found, {}, local_map, predicted, tracking), believed) << side * sigmas;
    }
  }
}

}  // namespace
}  // namespace slam::match_validator_test
