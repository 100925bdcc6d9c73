// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/estimator_thread.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <random>

#include "runtime/clock.hpp"
#include "support/simulated/room.hpp"
#include "support/wait_until.hpp"

namespace slam::estimator_thread_test {
namespace {

using namespace std::chrono_literals;
using test::waitUntil;

class Estimator : public testing::Test {
 protected:
  Estimator() { config.runtime.realtime = false; }
  void start(std::int32_t map_id = 0) {
    thread = std::make_unique<EstimatorThread>(
        config, channels->estimator(),
        std::make_unique<FrontEnd>(config.front_end, nullptr, FrontEndStart{.map_id = map_id}));
    thread->worker().start();
  }
  /// A scan of a room at the robot's place.
  void see() {
    received->scan = room.scan({}, random);
    received->scan.stamp = received->received = monotonicNow();
    ASSERT_TRUE(channels->samples.scans.tryPush(*received));
  }
  /// The newest snapshot as soon as one fulfils the condition.
  template <typename Condition>
  [[nodiscard]] bool told(Condition&& condition) {
    return waitUntil([&] { return channels->pose_for_supervisor.load(snapshot) && condition(snapshot); });
  }

  Config config;
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  std::unique_ptr<EstimatorThread> thread;
  std::unique_ptr<ReceivedScan> received = std::make_unique<ReceivedScan>();
  test::Room room;
  std::mt19937 random{1};
  PoseSnapshot snapshot;
};

TEST_F(Estimator, PublishesThePoseAtItsRateBetweenScans) {
  config.runtime.estimator_rate = 500.0;
  config.lcm.pose_rate = 25.0;
  start();
  int poses = 0;
  ASSERT_TRUE(told([&](const PoseSnapshot&) { return ++poses == 5; }));
  EXPECT_GE(thread->worker().ticks(), 80U) << "one in twenty ticks, and the fifth within its tick";
}

TEST_F(Estimator, HandsScansToTheFrontEndAndTheirKeyframesOn) {
  config.lcm.pose_rate = 1.0;
  start(7);
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.map_id == 7; }));
  EXPECT_EQ(snapshot.scans, 0);
  see();
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.scans == 1; }));
  EXPECT_EQ(snapshot.counters.scans, 1U);
  EXPECT_EQ(snapshot.scan_received, received->received);
  EXPECT_EQ(snapshot.pose.state, LocalisationState::kLocalised);
  EXPECT_EQ(channels->times.scan_work.summary().count, 1);
  EXPECT_FALSE(channels->lidar_stuck);
  int keyframes = 0;
  channels->front_end.keyframes.drain([&](const Keyframe& keyframe) {
    ++keyframes;
    EXPECT_EQ(keyframe.map_id, 7);
  });
  EXPECT_EQ(keyframes, 1);
  PoseSnapshot others;
  ASSERT_TRUE(channels->newest_pose.load(others));
  EXPECT_EQ(others.scans, 1);
  ASSERT_TRUE(channels->pose_for_graph.load(others));
  EXPECT_EQ(others.scans, 1);
}

TEST_F(Estimator, IsWokenByAScan) {
  config.runtime.estimator_rate = 0.5;  // its second tick is two seconds away
  config.lcm.pose_rate = 0.5;
  start(7);
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.map_id == 7; }));
  ASSERT_TRUE(waitUntil([&] { return thread->worker().ticks() == 1; }));
  see();
  channels->estimator_wakeup.notify();
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.scans == 1; }));
  EXPECT_EQ(thread->worker().ticks(), 1U);
}

TEST_F(Estimator, ReceivesWheelsAndGyro) {
  start();
  const Timestamp begin = monotonicNow();
  for (int i = 0; i < 100; ++i) {
    const Timestamp stamp = begin - 1s + i * 10ms;
    channels->samples.wheels.tryPush({{.stamp = stamp, .T_wheels_base = {0.005 * i, 0.0, 0.0}}, {}, 0});
    channels->samples.imu.tryPush({stamp, {0.0, 0.0, 0.0}, {0.0, 0.0, 9.81}});
  }
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.filter.wheels_fused > 50 && s.filter.gyro_fused > 50; }));
  EXPECT_NEAR(snapshot.odometry.twist.vx, 0.5, 0.1);
  EXPECT_TRUE(channels->moving);
}

TEST_F(Estimator, GivesACorrectionOfAnotherMapBackUnused) {
  start(7);
  see();
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.scans == 1; }));
  MapCorrection other(config.front_end.reference);  // of the map before: empty, so that nothing would be matched
  other.map_id = 6;
  other.newest = 0;
  other.keyframes.push_back({0, {5.0, 0.0, 0.0}});
  ASSERT_TRUE(channels->front_end.corrections.tryPush(&other));
  MapCorrection* back = nullptr;
  ASSERT_TRUE(waitUntil([&] {
    channels->front_end.used_corrections.popOne([&](MapCorrection* correction) { back = correction; });
    return back != nullptr;
  }));
  EXPECT_EQ(back, &other);
  see();
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.scans == 2; }));
  EXPECT_NEAR(snapshot.pose.T_map_base.x, 0.0, 0.1);
}

TEST_F(Estimator, PutsTheRobotAtAGivenPoseAndGoesOnInAnotherMap) {
  start(7);
  see();
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.scans == 1; }));
  channels->commands.set_poses.tryPush({{3.0, -2.0, 1.0}});
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.pose.T_map_base.x > 2.9; }));
  EXPECT_NEAR(snapshot.pose.T_map_base.y, -2.0, 0.1);
  EXPECT_NEAR(std::sqrt(snapshot.pose.covariance(0, 0)), 0.2, 0.02) << "as sure as a person is";
  EXPECT_NEAR(std::sqrt(snapshot.pose.covariance(2, 2)), 0.1, 0.02);
  channels->front_end.front_ends.tryPush(new FrontEnd(config.front_end, nullptr, FrontEndStart{.map_id = 8}));
  ASSERT_TRUE(told([](const PoseSnapshot& s) { return s.map_id == 8; }));
  std::unique_ptr<FrontEnd> old;
  channels->front_end.used_front_ends.popOne([&](FrontEnd* used) { old.reset(used); });
  ASSERT_NE(old, nullptr);
  EXPECT_EQ(old->mapId(), 7);
}

}  // namespace
}  // namespace slam::estimator_thread_test
