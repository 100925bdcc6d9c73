// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/keyframe_selector.hpp"

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

namespace slam::keyframe_selector_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

TEST(KeyframeSelector, NoisyWheelsGiveLessOfTheWayAlongACorridor) {
  /// @return [m^2/m] variance of the way along the corridor, where the lidar did not see it
  const auto variance = [](double noise) {
    Drive drive;
    drive.gyro.there = false;
    drive.enter(test::Room{.length = 60.0, .width = 3.0, .reach = 12.0});
    drive.truth = {-28.0, 0.0, 0.0};
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    double sum = 0.0, way = 0.0;
    while (drive.truth.x < 5.0) {  // the first metres in sight of the corridor's end
      drive.wheels.leap({noise * std::sqrt(0.05) * normal(random), 0.0, 0.0});
      drive.run(0.1, {0.5, 0.0, 0.0});
      const Keyframe* keyframe = drive.last.keyframe;
      if (keyframe == nullptr || keyframe->refresh || keyframe->observable == 3) continue;
      sum += keyframe->step_covariance(0, 0);
      way += keyframe->T_previous_base.x;
    }
    EXPECT_GT(way, 5.0) << "[m]";
    return sum / way;
  };
  const double good = variance(0.0), noisy = variance(0.2);
  EXPECT_GT(noisy, 1.5 * good);
  EXPECT_LT(noisy, 10.0 * good);
}

TEST(KeyframeSelector, StopsKeepingScansOfAKnownPlaceButGoesOnLooking) {
  Drive drive;
  drive.run(2.0, kStand);
  for (int lap = 0; lap < 4; ++lap) drive.run(16.0, kCurve);  // circles of 0.75 m radius
  const auto known = drive.front_end->counters().keyframes;
  bool looked = false;
  for (int step = 0; step < 160; ++step) {
    drive.run(0.2, kCurve);
    looked |= drive.last.keyframe != nullptr && drive.last.keyframe->refresh;
  }
  EXPECT_EQ(drive.front_end->counters().keyframes, known);
  EXPECT_TRUE(looked);
}

/// Cuts a drive down to what the selector sees: clouds at poses.
class Selected {
 public:
  explicit Selected(const FrontEndConfig& given = {}, const FrontEndStart& start = {})
      : config(given),
        local_map(config.reference, config.lidar.T_base_lidar, config.localise_only),
        selector(config.keyframe, config.lidar, config.localise_only, 0.1, start) {
    cloud.stamp = Timestamp{100s};
    cloud.points.push_back({.position = {1.0, 0.5}});
  }
  const Keyframe* keep(const Pose2& T_map_base, int observable = 3) {
    MatchResult match;
    match.observable = observable;
    selector.addDrift(T_map_base, observable == 0 ? nullptr : &match, monitor, by_gyro);
    return selector.keep(cloud, T_map_base, match, sensitivity, local_map);
  }

  FrontEndConfig config;
  LocalMap local_map;
  OdometryMonitor monitor{WheelMonitor(EkfConfig{}), GyroMonitor(EkfConfig{}), ScanMonitor(EkfConfig{}),
                          HeadingMonitor()};
  bool by_gyro = false;
  KeyframeSelector selector;
  Cloud cloud;
  Sensitivity sensitivity = Sensitivity::Zero();
};

TEST(KeyframeSelector, CountsIdsFromTheMapsSizeAndSegmentsFromZero) {
  Selected selected({}, {.map_id = 7, .first_keyframe = 40, .in_known_map = true});
  const Keyframe* keyframe = selected.keep({1.0, 2.0, 0.3});
  EXPECT_EQ(keyframe->map_id, 7);
  EXPECT_EQ(keyframe->id, 40);
  EXPECT_EQ(keyframe->origin, KeyframeOrigin::kLost) << "it has to be found in the map";
  EXPECT_EQ(keyframe->T_previous_base, Pose2{});
  keyframe = selected.keep({1.2, 2.0, 0.3});
  EXPECT_EQ(keyframe->id, 41);
  EXPECT_EQ(keyframe->origin, KeyframeOrigin::kContinued);
  selected.selector.beginSession(KeyframeOrigin::kGiven, std::numbers::pi);
  selected.local_map.clear({0.0, 0.0});
  keyframe = selected.keep({5.0, 0.0, 0.0});
  EXPECT_EQ(keyframe->id, 42);
  EXPECT_EQ(keyframe->session, 1);
  EXPECT_EQ(keyframe->origin, KeyframeOrigin::kGiven);
}

/// It told the whole pose to 1 cm and 1 mrad.
MatchResult fullMatch() {
  MatchResult match;
  match.status = MatchStatus::kConverged;
  match.observable = 3;
  match.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-6).asDiagonal();
  return match;
}

TEST(KeyframeSelector, AKeyframesCovarianceGrowsByWhatItDrawsAnewAndByTheLeverOfItsHeading) {
  Selected selected;
  const auto keep = [&](const Pose2& T_map_base) {
    return selected.selector.keep(selected.cloud, T_map_base, fullMatch(), selected.sensitivity, selected.local_map)
        ->covariance;
  };
  selected.keep({}, 0);
  EXPECT_EQ(selected.local_map.keyframes()[0].covariance, Eigen::Matrix3d::Zero());
  EXPECT_EQ(keep({}), Eigen::Matrix3d::Zero()) << "it was laid on what is drawn";
  const Pose2 next{0.2, 0.0, 0.5 * std::numbers::pi};
  EXPECT_NEAR(keep(next)(0, 0), 1e-4, 1e-12) << "all of it is new";
  selected.cloud.points.push_back({.position = {-1.0, 0.5}});  // on the last one's point, from here
  const Eigen::Matrix3d covariance = keep(next * Pose2{2.0, 0.0, 0.0});
  EXPECT_NEAR(covariance(0, 0), 1e-4 + 0.25 * 1e-4, 1e-12) << "half of it is new";
  EXPECT_NEAR(covariance(1, 1), 1e-4 + 4.0 * 1e-6 + 0.25 * 1e-4, 1e-12);
}

TEST(KeyframeSelector, AKeyframeHasTheEffectOfSystematicErrorsInItsOwnAxes) {
  Selected selected;
  selected.sensitivity.col(kRangeBias) = Eigen::Vector3d(2.0, 0.0, 0.1);
  const Keyframe* keyframe = selected.keep({1.0, 0.0, 0.5 * std::numbers::pi});
  EXPECT_TRUE(keyframe->sensitivity.col(kRangeBias).isApprox(Eigen::Vector3d(0.0, -2.0, 0.1)));
  EXPECT_TRUE(selected.local_map.keyframes()[0].sensitivity.isApprox(keyframe->sensitivity));
  EXPECT_TRUE(StoredScan(*keyframe).sensitivity.isApprox(keyframe->sensitivity));
}

TEST(KeyframeSelector, AKeyframesCovarianceGrowsByTheWheelsWayWhereNoMatchGivesIt) {
  Selected selected;
  selected.keep({}, 0);
  selected.keep({0.5, 0.0, 0.0}, 0);
  const Keyframe* keyframe = selected.keep({1.0, 0.0, 0.0}, 0);
  EXPECT_NEAR(keyframe->covariance(0, 0), EkfConfig{}.wheelTranslationVariance(1.0), 1e-12);
}

TEST(KeyframeSelector, AKeyframesHeadingIsAsSureAsWhatGaveTheTurnWhereNoMatchDid) {
  const auto varianceOf = [](bool by_gyro) {
    Selected selected;
    selected.keep({}, 0);
    selected.by_gyro = by_gyro;
    const Keyframe* keyframe = selected.keep({0.0, 0.0, 1.0}, 0);
    return std::pair(keyframe->step_covariance(2, 2), keyframe->covariance(2, 2));
  };
  const auto [wheels_step, wheels] = varianceOf(false);
  EXPECT_NEAR(wheels, EkfConfig{}.headingVariance(0.0, 0.0, 1.0, false), 1e-12);
  const auto [gyro_step, gyro] = varianceOf(true);
  EXPECT_NEAR(gyro, EkfConfig{}.headingVariance(0.0, 0.0, 1.0, true), 1e-12);
  EXPECT_LT(gyro_step, 0.01 * wheels_step) << "the graph would let the turn go by degrees";
}

TEST(KeyframeSelector, WhatNoMatchGaveCountsNoMoreWhereTheMapIsKnown) {
  Selected selected;
  selected.keep({}, 0);
  selected.selector.addDrift({3.0, 0.0, 0.0}, nullptr, selected.monitor, false);
  MatchResult known = fullMatch();
  known.overlap = known.known_ratio = 1.0;
  ASSERT_TRUE(
      selected.selector.select(selected.cloud, {3.0, 0.0, 0.0}, known, selected.sensitivity, selected.local_map)
          ->refresh);
  const Keyframe* keyframe = selected.keep({3.0, 0.0, 0.0});
  EXPECT_LT(keyframe->covariance.norm(), 1e-9);
}

TEST(KeyframeSelector, InAGivenMapASegmentForgetsTheOneBefore) {
  FrontEndConfig config;
  config.localise_only = true;
  Selected selected(config, {.first_keyframe = 40, .in_known_map = true});
  selected.keep({});
  selected.keep({0.2, 0.0, 0.0});
  selected.selector.beginSession(KeyframeOrigin::kLost, std::numbers::pi);
  EXPECT_EQ(selected.keep({0.4, 0.0, 0.0})->id, 40);
}

TEST(KeyframeSelector, ReportsHowFarASessionsHeadingIsKnown) {
  Selected selected;
  EXPECT_EQ(selected.keep({})->heading_tolerance, std::numbers::pi);
  selected.selector.beginSession(KeyframeOrigin::kLost, 0.2);
  EXPECT_EQ(selected.selector.headingTolerance(), 0.2);
  EXPECT_EQ(selected.keep({3.0, 0.0, 0.0})->heading_tolerance, 0.2);
}

TEST(KeyframeSelector, AStepIsAsUncertainAsWhatGaveItsWay) {
  const auto variance = [](int observable) {
    Selected selected;
    selected.keep({});
    return selected.keep({4.0, 0.0, 0.0}, observable)->step_covariance(0, 0);
  };
  const double matched = variance(3), predicted = variance(0);
  EXPECT_NEAR(matched, 0.01 * 0.01 * 4.0, 1e-7) << "the walk of DriftConfig";
  EXPECT_NEAR(predicted, matched + EkfConfig{}.wheelTranslationVariance(4.0), 1e-7) << "and of the wheels";
}

TEST(KeyframeSelector, HandsOverWhatMovesWithTheRobotAsSeenFromAbove) {
  for (const bool upside_down : {false, true}) {
    FrontEndConfig config;
    config.lidar.upside_down = upside_down;
    Selected selected(config);
    selected.cloud.body.millimetres[40] = 300;
    const Keyframe* keyframe = selected.keep({});
    EXPECT_EQ(keyframe->body.degrees(), 1);
    EXPECT_NEAR(keyframe->body.middle(), upside_down ? -40.5 : 40.5, 1e-9);
    EXPECT_GT(keyframe->body_margin, 0.0);
  }
}

}  // namespace
}  // namespace slam::keyframe_selector_test
