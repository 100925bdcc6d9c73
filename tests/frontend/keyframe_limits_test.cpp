// SPDX-License-Identifier: BSD-3-Clause
// When a scan becomes a keyframe or a look, each limit by itself, and what a keyframe claims of its step.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "frontend/place_drive.hpp"

namespace slam::keyframe_limits_test {
namespace {

using test::PlaceDrive;
using Kept = PlaceDrive::Kept;

const Eigen::Vector3d kStand(0, 0, 0), kAhead(0.1, 0, 0), kSpin(0, 0, 0.1);  // 2 cm, 0.02 rad from scan to scan

/// Nothing is familiar: scans become keyframes by the way since the last one alone.
FrontEndConfig unfamiliar() {
  FrontEndConfig config;
  config.keyframe.known_ratio = 1.1;
  return config;
}
/// All is familiar: they become looks.
FrontEndConfig familiar() {
  FrontEndConfig config;
  config.keyframe.known_ratio = 0.0;
  config.keyframe.refresh_period = 1e9;
  return config;
}

/// The kept ones but the first, of which each step is `of`.
template <typename Of>
std::vector<double> steps(const PlaceDrive& drive, Of&& of) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < drive.kept.size(); ++i) steps.push_back(of(drive.kept[i - 1], drive.kept[i]));
  return steps;
}
double way(const Kept& a, const Kept& b) { return between(a.truth, b.truth).translation().norm(); }
double turn(const Kept& a, const Kept& b) { return std::abs(between(a.truth, b.truth).theta); }
double seconds(const Kept& a, const Kept& b) { return toSeconds(b.stamp - a.stamp); }

void expectWithin(const std::vector<double>& values, double low, double high, std::size_t least) {
  ASSERT_GE(values.size(), least);
  for (const double value : values) {
    EXPECT_GE(value, low);
    EXPECT_LE(value, high);
  }
}

TEST(KeyframeLimits, AKeyframeComesAfterItsDistanceOrItsTurn) {
  for (const double scale : {1.0, 1.5}) {
    FrontEndConfig config = unfamiliar();
    config.keyframe.translation = 0.20 * scale;
    config.keyframe.rotation = 0.17 * scale;
    PlaceDrive ahead(test::furnishedRoom(), config), spin(test::furnishedRoom(), config);
    ahead.run(1.0, kStand);
    ahead.run(14.0, kAhead);
    expectWithin(steps(ahead, way), 0.20 * scale - 0.01, 0.20 * scale + 0.03, 4);
    spin.run(1.0, kStand);
    spin.run(14.0, kSpin);
    expectWithin(steps(spin, turn), 0.17 * scale - 0.005, 0.17 * scale + 0.025, 4);
    for (const PlaceDrive* drive : {&ahead, &spin}) {
      EXPECT_TRUE(std::none_of(drive->kept.begin(), drive->kept.end(), [](const Kept& k) { return k.look; }));
    }
  }
  PlaceDrive standing(test::furnishedRoom(), unfamiliar());
  standing.run(10.0, kStand);
  EXPECT_EQ(standing.kept.size(), 1U) << "time alone makes none";
}

TEST(KeyframeLimits, AKnownPlaceIsLookedAtAfterADistanceOrATurnOrATime) {
  PlaceDrive ahead(test::furnishedRoom(), familiar()), spin(test::furnishedRoom(), familiar());
  ahead.run(1.0, kStand);
  ahead.run(14.0, kAhead);
  expectWithin(steps(ahead, way), 0.19, 0.23, 4);
  spin.run(1.0, kStand);
  spin.run(14.0, kSpin);
  expectWithin(steps(spin, turn), 0.165, 0.195, 4);
  for (const double period : {1.0, 2.0}) {
    FrontEndConfig config = familiar();
    config.keyframe.refresh_period = period;
    PlaceDrive standing(test::furnishedRoom(), config);
    standing.run(12.0, kStand);
    expectWithin(steps(standing, seconds), period, period + 0.21, 4);
    for (std::size_t i = 1; i < standing.kept.size(); ++i) EXPECT_TRUE(standing.kept[i].look);
  }
}

TEST(KeyframeLimits, AGivenMapIsLookedAtAndNotExtended) {
  FrontEndConfig config = unfamiliar();
  config.localise_only = true;
  PlaceDrive drive(test::furnishedRoom(), config);
  drive.run(1.0, kStand);
  auto correction = std::make_unique<MapCorrection>(drive.front_end->config().reference);
  std::mt19937 random(1);
  for (int i = 0; i < 4; ++i) correction->reference.add({}, test::furnishedRoom().scan({}, 0.01, random));
  correction->keyframes.push_back({0, {}});
  correction->newest = 0;
  correction->T_map_session = Pose2{};
  drive.front_end->apply(*correction);
  const auto keyframes = drive.front_end->counters().keyframes;
  drive.run(10.0, kAhead);
  EXPECT_EQ(drive.front_end->counters().keyframes, keyframes);
  EXPECT_GT(drive.kept.size(), 3U);
  EXPECT_TRUE(drive.kept.back().look);
}

/// A corridor without doors or ends, in a map that it crosses at an angle.
class DriftInACorridor : public testing::TestWithParam<double> {
 protected:
  PlaceDrive corridor(double blind_wheels = 0.10) const {
    FrontEndConfig config = unfamiliar();
    config.ekf.translation_noise = blind_wheels;
    return PlaceDrive(test::endlessCorridor(), config, {.T_map_base = {1.0, -2.0, GetParam()}});
  }
  /// Of one keyframe's step: along the corridor the wheels' noise, across it that of scans.
  static void expectBlindAhead(const Kept& kept, double wheels_noise) {
    const double distance = kept.T_previous_base.translation().norm();
    const double along = wheels_noise * wheels_noise * distance + 0.01 * 0.01 * distance + 1e-8;
    const double across = 0.01 * 0.01 * distance + 1e-8;
    EXPECT_EQ(kept.observable, 2);
    EXPECT_NEAR(kept.step_covariance(0, 0), along, 0.2 * along);
    EXPECT_NEAR(kept.step_covariance(1, 1), across, across);
    EXPECT_LT(std::abs(kept.step_covariance(0, 1)), 0.1 * along);
    EXPECT_LT(kept.step_covariance(2, 2), 1e-4);
  }
};

TEST_P(DriftInACorridor, LiesAlongTheRobotsWayHoweverTheMapLies) {
  for (const double noise : {0.10, 0.20}) {
    PlaceDrive drive = corridor(noise);
    drive.run(1.0, kStand);
    drive.run(14.0, kAhead);
    ASSERT_GE(drive.kept.size(), 5U);
    double way = 0.0;  // [m]
    for (std::size_t i = 1; i < drive.kept.size(); ++i) {
      expectBlindAhead(drive.kept[i], noise);
      way += drive.kept[i].T_previous_base.translation().norm();
    }
    const Eigen::Matrix3d& pose = drive.kept.back().covariance;  // in map
    EXPECT_NEAR(pose(0, 0), noise * noise * way, 0.2 * noise * noise * way);
    EXPECT_LT(pose(1, 1), 0.1 * pose(0, 0));
  }
}

TEST_P(DriftInACorridor, TurnsWithTheMapAsItIsCorrected) {
  PlaceDrive drive = corridor();
  drive.run(1.0, kStand);
  drive.run(10.0, kAhead);
  const std::size_t count = drive.kept.size();
  ASSERT_GE(count, 4U);
  while (drive.kept.size() == count) drive.run(0.2, kAhead);
  drive.run(1.4, kAhead);  // most of the way to the next one
  ASSERT_EQ(drive.kept.size(), count + 1);
  const Pose2 T_new_old{0.5, -0.3, 1.2};
  auto correction = std::make_unique<MapCorrection>(drive.front_end->config().reference);
  correction->reference.clear((T_new_old * drive.front_end->estimate(drive.now).T_map_base).translation());
  std::mt19937 random(1);
  for (std::size_t i = 0; i < drive.kept.size(); ++i) {
    const Pose2 moved = T_new_old * drive.kept[i].T_map_base;
    correction->reference.add(moved, test::endlessCorridor().scan(drive.kept[i].truth, 0.01, random));
    correction->keyframes.push_back({static_cast<int>(i), moved});
  }
  correction->newest = static_cast<int>(drive.kept.size()) - 1;
  drive.front_end->apply(*correction);
  while (drive.kept.size() == count + 1) drive.run(0.2, kAhead);
  expectBlindAhead(drive.kept.back(), 0.10);
}

INSTANTIATE_TEST_SUITE_P(Headings, DriftInACorridor, testing::Values(0.0, 0.9, std::numbers::pi / 2, -2.4));

TEST(Drift, OfScansThatMatchIsTheirOwnInAllDirections) {
  FrontEndConfig config = unfamiliar();
  config.keyframe.drift = {.translation = 0.03, .rotation_per_metre = 0.004, .rotation_per_radian = 0.0};
  PlaceDrive ahead(test::furnishedRoom(), config);
  config.keyframe.drift = {.translation = 0.03, .rotation_per_metre = 0.0, .rotation_per_radian = 0.02};
  PlaceDrive spin(test::furnishedRoom(), config);
  ahead.run(1.0, kStand);
  ahead.run(10.0, kAhead);
  ASSERT_GE(ahead.kept.size(), 4U);
  for (std::size_t i = 1; i < ahead.kept.size(); ++i) {
    const double distance = ahead.kept[i].T_previous_base.translation().norm();
    EXPECT_NEAR(ahead.kept[i].step_covariance(0, 0), 0.03 * 0.03 * distance, 0.3 * 0.03 * 0.03 * distance);
    EXPECT_NEAR(ahead.kept[i].step_covariance(1, 1), 0.03 * 0.03 * distance, 0.3 * 0.03 * 0.03 * distance);
    EXPECT_NEAR(ahead.kept[i].step_covariance(2, 2), 0.004 * 0.004 * distance, 0.3 * 0.004 * 0.004 * distance);
  }
  spin.run(1.0, kStand);
  spin.run(10.0, kSpin);
  ASSERT_GE(spin.kept.size(), 4U);
  for (std::size_t i = 1; i < spin.kept.size(); ++i) {
    const double turned = std::abs(spin.kept[i].T_previous_base.theta);
    EXPECT_NEAR(spin.kept[i].step_covariance(2, 2), 0.02 * 0.02 * turned, 0.3 * 0.02 * 0.02 * turned);
  }
}

}  // namespace
}  // namespace slam::keyframe_limits_test
