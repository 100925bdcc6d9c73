// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/pose_thread.hpp"

#include <bot_core/pose_t.hpp>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <poll.h>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <vector>

#include "app/threads/bus_thread.hpp"
#include "bus/channels.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "support/allocations.hpp"
#include "support/wait_until.hpp"

namespace slam::pose_thread_test {
namespace {

using namespace std::chrono_literals;
using test::waitUntil;

/// The pose thread, and somebody who listens.
class Pose : public testing::Test {
 protected:
  Pose() {
    config.lcm.url = "udpm://239.255.76.67:7672?ttl=0";
    config.runtime.realtime = false;
    for (const char* name : {channel::kOdometry, channel::kSlamPose, channel::kPose}) {
      listener.subscribe(name, [this, name](std::span<const std::uint8_t> data) {
        heard[name].emplace_back(data.begin(), data.end());
      });
    }
    listener.tend(monotonicNow());
  }
  void tell() {
    snapshot.pose.stamp = snapshot.odometry.stamp = snapshot.scan_received = monotonicNow();
    channels->newest_pose.store(snapshot);
    channels->pose_wakeup.notify();
  }
  std::uint64_t sent() const { return channels->bus_counters.published; }
  std::uint64_t failed() const { return channels->bus_counters.failures; }
  template <typename Message>
  Message decoded(const char* name, std::size_t i) {
    Message message{};
    const auto& data = heard[name].at(i);
    EXPECT_EQ(message.decode(data.data(), 0, static_cast<int>(data.size())), static_cast<int>(data.size()));
    return message;
  }

  Config config;
  WallClock clock;
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  LcmLink listener{"udpm://239.255.76.67:7672?ttl=0"};
  LcmLink link{"udpm://239.255.76.67:7672?ttl=0"};  // as of the bus thread
  PoseThread pose{config, channels->pose(), clock, link.sender()};
  PoseSnapshot snapshot;
  std::map<std::string, std::vector<std::vector<std::uint8_t>>> heard;
};

TEST_F(Pose, SendsPoseOnlyWhileThePoseIsValid) {
  using enum LocalisationState;
  link.tend(monotonicNow());
  if (listener.descriptor() < 0) GTEST_SKIP() << "this machine has no multicast";
  pose.worker().start();
  snapshot.map_id = 5;
  std::uint64_t messages = 0;
  for (const LocalisationState state : {kInitialising, kLocalised, kDegraded, kLost}) {
    snapshot.pose.state = state;
    snapshot.pose.T_map_base = {1.0 * static_cast<int>(state), 0.0, 0.0};
    snapshot.odometry.T_odom_base = {0.0, 1.0 * static_cast<int>(state), 0.0};
    snapshot.scans = state == kInitialising ? 0 : 1;  // one scan, which three snapshots tell of
    tell();
    messages += state == kLocalised || state == kDegraded ? 3 : 2;
    ASSERT_TRUE(waitUntil([&] { return sent() + failed() >= messages; }));
  }
  if (sent() == 0) GTEST_SKIP() << "this machine has no multicast";
  ASSERT_TRUE(waitUntil([&] {
    listener.receive();
    return heard[channel::kSlamPose].size() == 4 && heard[channel::kPose].size() == 2;
  }));
  EXPECT_EQ(decoded<bot_core::pose_t>(channel::kPose, 0).pos[0], 1.0);
  EXPECT_EQ(decoded<bot_core::pose_t>(channel::kPose, 1).pos[0], 2.0);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto estimate = decoded<pose_estimate_t>(channel::kSlamPose, i);
    EXPECT_EQ(estimate.state, i);
    EXPECT_EQ(estimate.map_id, 5);
    EXPECT_EQ(estimate.x, static_cast<double>(i));
    EXPECT_EQ(decoded<odometry_t>(channel::kOdometry, i).y, static_cast<double>(i));
  }
  EXPECT_EQ(channels->times.scan_to_pose.summary().count, 1) << "each scan counts once";
  int poses = 0;
  channels->sent_poses.drain([&](const SentPose& each) {
    EXPECT_EQ(static_cast<int>(each.pose.state), poses++) << "all of them go to the records";
  });
  EXPECT_EQ(poses, 4);
}

TEST_F(Pose, GoesToTheRecordsWithoutANetwork) {
  pose.worker().start();  // nobody opens its socket
  snapshot.pose.state = LocalisationState::kLocalised;
  tell();
  int poses = 0;
  ASSERT_TRUE(waitUntil([&] {
    channels->sent_poses.drain([&](const SentPose&) { ++poses; });
    return poses == 1 && failed() == 3;
  }));
  EXPECT_EQ(sent(), 0U);
}

}  // namespace
}  // namespace slam::pose_thread_test
