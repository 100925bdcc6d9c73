// SPDX-License-Identifier: BSD-3-Clause
// What the window keeps when the map turns, and the limits of what is joined and held in it.
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "estimation/ekf_timeline.hpp"

namespace slam::ekf_timeline_map_test {
namespace {

using std::chrono::milliseconds;

Timestamp at(std::int64_t ms) { return Timestamp(milliseconds(1'000'000 + ms)); }
WheelSample wheels(std::int64_t ms, const Pose2& pose) { return {.stamp = at(ms), .T_wheels_base = pose}; }

/// A match that saw one direction of the plane and the heading, far better along some axes than along others.
PoseMeasurement corridorMatch(std::int64_t ms, const Pose2& pose, double blind_bearing) {
  PoseMeasurement match{.stamp = at(ms), .T_map_base = pose};
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(blind_bearing, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  match.covariance = turn * Eigen::Vector3d(4e-2, 1e-4, 1e-5).asDiagonal() * turn.transpose();
  match.directions.col(0) = turn.col(1);
  match.directions.col(1) = Eigen::Vector3d::UnitZ();
  match.directions.col(2) = turn.col(0);
  match.observable = 2;
  return match;
}

PoseMeasurement inNew(PoseMeasurement match, const Pose2& T_new_old) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(T_new_old.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  match.T_map_base = T_new_old * match.T_map_base;
  match.covariance = turn * match.covariance * turn.transpose();
  match.directions = turn * match.directions;
  return match;
}

/// The robot drives along its x axis, sees matches that are blind in different directions, and a wheel sample arrives
/// late: the window is run again from before the matches.
template <typename Turn>
Ekf drive(const Pose2& start, const Pose2& T_new_old, bool matches_in_new, Turn&& turn) {
  EkfConfig config;
  config.initial_pose = start;
  EkfTimeline timeline(config, {});
  const auto add = [&](const PoseMeasurement& match) {
    timeline.add(matches_in_new ? inNew(match, T_new_old) : match);
  };
  for (int ms = 0; ms <= 400; ms += 20) {
    if (ms == 100) continue;
    if (ms == 120) add(corridorMatch(ms, {0.07, 0.02, 0.01}, 0.4));
    if (ms == 160) add(corridorMatch(ms, {0.10, -0.01, -0.01}, 1.4));
    if (ms == 200) {
      PoseMeasurement whole = corridorMatch(ms, {0.11, 0.01, 0.0}, -0.7);
      whole.observable = 3;
      add(whole);
    }
    timeline.add(wheels(ms, {0.5e-3 * ms, 0, 0}));
  }
  turn(timeline);
  timeline.add(wheels(100, {0.05, 0, 0}));
  EXPECT_EQ(timeline.lateFused(), 1U);
  return timeline.at(at(420));
}

TEST(EkfTimelineInATurnedMap, StoredMatchesTurnWithIt) {
  for (const Pose2& T_new_old : {Pose2{3.0, -2.0, 0.9}, Pose2{0.0, 0.0, std::numbers::pi / 2}, Pose2{-7, 1, -2.5}}) {
    const Ekf turned = drive({}, T_new_old, false, [&](EkfTimeline& timeline) { timeline.transform(T_new_old); });
    const Ekf always = drive(T_new_old, T_new_old, true, [](EkfTimeline&) {});
    Ekf::Vector error = turned.state() - always.state();
    error[Ekf::kTheta] = wrapAngle(error[Ekf::kTheta]);
    EXPECT_LT(error.norm(), 1e-9);
    EXPECT_LT((turned.covariance() - always.covariance()).norm(), 1e-9 * always.covariance().norm());
  }
}

TEST(EkfTimelineInATurnedMap, TheStateBeforeTheWindowTurnsWithIt) {
  const Pose2 T_new_old{3.0, -2.0, 0.9};
  EkfTimeline timeline({}, {});
  for (int ms = 0; ms <= 1500; ms += 20) timeline.add(wheels(ms, {0.5e-3 * ms, 0, 0}));
  const Pose2 before = timeline.at(timeline.oldestStamp()).pose();
  ASSERT_GT(before.x, 0.1);
  timeline.transform(T_new_old);
  const Pose2 after = timeline.at(timeline.oldestStamp()).pose();
  EXPECT_LT((after.vector() - (T_new_old * before).vector()).norm(), 1e-12);
}

TEST(EkfTimeline, KeepsItsWindowAndNoMore) {
  for (const double window : {0.5, 1.0}) {
    EkfTimeline timeline({}, {.window = window});
    for (int ms = 0; ms <= 3000; ms += 10) timeline.add(ImuSample{.stamp = at(ms)});
    EXPECT_NEAR(toSeconds(timeline.newestStamp() - timeline.oldestStamp()), window, 0.021);
    const auto late = [&](double age) {
      const auto dropped = timeline.tooOld();
      timeline.add(ImuSample{.stamp = at(3000) - fromSeconds(age)});
      return timeline.tooOld() == dropped;
    };
    EXPECT_TRUE(late(0.95 * window));
    EXPECT_FALSE(late(1.05 * window));
  }
}

TEST(EkfTimeline, ASampleThatComesMuchTooSoonIsJoinedWithTheLateOnesBefore) {
  // Samples 20 ms apart, then one after a share of that: the robot drives 1 m/s all the time, the stamp lies.
  const auto speedAfter = [](double share, int interval) {
    EkfTimeline timeline({}, {});
    double x = 0.0;
    std::int64_t ms = 0;
    for (int i = 0; i < 10; ++i, ms += interval) timeline.add(wheels(ms, {x += 1e-3 * interval, 0, 0}));
    const Timestamp soon = at(ms - interval) + fromSeconds(1e-3 * interval * share);
    timeline.add(WheelSample{.stamp = soon, .T_wheels_base = {x + 1e-3 * interval, 0, 0}});
    timeline.add(WheelSample{.stamp = soon + milliseconds(interval), .T_wheels_base = {x + 2e-3 * interval, 0, 0}});
    return timeline.at(soon + fromSeconds(5e-4 * interval)).twist().vx;  // within the interval that begins there
  };
  EXPECT_NEAR(speedAfter(0.45, 18), 1.0, 0.05);
  // 6 ms after 10 ms was taken sooner in truth, and so was what lies more than 10 ms apart.
  const auto meanBefore = [](double share, int interval) {
    EkfTimeline timeline({}, {});
    double x = 0.0;
    std::int64_t ms = 0;
    for (int i = 0; i < 10; ++i, ms += interval) timeline.add(wheels(ms, {x += 1e-3 * interval, 0, 0}));
    const Timestamp last = at(ms - interval), soon = last + fromSeconds(1e-3 * interval * share);
    timeline.add(WheelSample{.stamp = soon, .T_wheels_base = {x + 1e-3 * interval, 0, 0}});
    timeline.add(WheelSample{.stamp = soon + milliseconds(200), .T_wheels_base = {x + 1e-3 * interval + 0.2, 0, 0}});
    return timeline.at(last + fromSeconds(0.5e-3 * interval * share)).twist().vx;
  };
  EXPECT_NEAR(meanBefore(0.45, 18), 2.0 / 1.45, 0.05) << "joined: two ways in 1.45 intervals";
  EXPECT_NEAR(meanBefore(0.55, 18), 1.0 / 0.55, 0.05) << "more than half of the interval";
  EXPECT_NEAR(meanBefore(0.45, 40), 1.0 / 0.45, 0.05) << "18 ms: no jitter";
}

TEST(EkfTimeline, MatchesComeBeforeWheelsAndThoseBeforeTheGyroOfOneStamp) {
  // A gyro of the same stamp as the wheels is used after them, whichever came first.
  EkfTimeline one({}, {}), other({}, {});
  for (int ms = 0; ms <= 200; ms += 20) {
    one.add(wheels(ms, {1e-3 * ms, 0, 0}));
    one.add(ImuSample{.stamp = at(ms), .gyro = {0, 0, 0.3}});
    other.add(ImuSample{.stamp = at(ms), .gyro = {0, 0, 0.3}});
    other.add(wheels(ms, {1e-3 * ms, 0, 0}));
  }
  EXPECT_EQ(one.at(at(210)).state(), other.at(at(210)).state());
  EXPECT_GT(one.at(at(210)).twist().omega, 0.2);
}

}  // namespace
}  // namespace slam::ekf_timeline_map_test
