// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_state.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "bus/messages.hpp"
#include "tools/web/map_tiles.hpp"

namespace slam::web_state_test {
namespace {

using namespace std::chrono_literals;
constexpr std::int64_t kUtime = 1'700'000'000'000'000;
constexpr Timestamp kNow{Duration(100s)};

class State : public testing::Test {
 protected:
  void drive(double from, double to, std::int32_t map_id = 1) {  // along x, at 1 m/s and 100 Hz
    for (double x = from; x < to; x += 0.01) pose(x, 0.0, 0.0, map_id);
  }
  void pose(double x, double y, double theta, std::int32_t map_id = 1,
            LocalisationState state = LocalisationState::kLocalised) {
    pose_estimate_t message{};
    message.utime = utime_ += 10'000;
    message.map_id = map_id;
    message.x = x;
    message.y = y;
    message.theta = theta;
    message.state = static_cast<std::uint8_t>(state);
    state_->take(message, kNow);
  }
  void health(std::int64_t loop_closures, double uptime) {
    health_t message{};
    message.uptime = uptime;
    message.ncounters = 1;
    counter_t counter{};
    counter.name = "loop_closures";
    counter.value = loop_closures;
    message.counters.push_back(counter);
    state_->take(message, kNow);
  }

  Config config_;
  std::optional<WebState> state_{std::in_place, config_};
  std::int64_t utime_ = kUtime;
};

TEST_F(State, PlacesEachBeamWhereTheRobotWasAtItsTime) {
  drive(0.0, 1.0);
  LaserScan scan;
  scan.push({2.0F, 0.0F, 0.0F});  // half a second ago, at 0.5 m
  scan.push({2.0F, 0.0F, 0.2F});  // at 0.7 m
  scan.push({0.0F, 1.0F, 0.2F});  // no return
  state_->take(toMessage(scan, utime_ - 500'000), kNow);
  ASSERT_EQ(state_->scan().size(), 2U);
  EXPECT_NEAR(state_->scan()[0].x(), 2.49, 0.011);
  EXPECT_NEAR(state_->scan()[1].x(), 2.69, 0.011);
  EXPECT_NEAR(state_->scan()[0].y(), 0.0, 1e-6);
}

TEST_F(State, HoldsWhereTheLidarSits) {
  config_.front_end.lidar.T_base_lidar = {0.1, 0.0, std::numbers::pi / 2.0};
  config_.front_end.lidar.upside_down = true;
  state_.emplace(config_);
  drive(0.0, 0.1);
  LaserScan scan;
  scan.push({1.0F, static_cast<float>(std::numbers::pi / 2.0), 0.0F});  // upside down: to the lidar's right, forward
  state_->take(toMessage(scan, utime_), kNow);
  ASSERT_EQ(state_->scan().size(), 1U);
  EXPECT_NEAR(state_->scan()[0].x(), 1.19, 0.011);
  EXPECT_NEAR(state_->scan()[0].y(), 0.0, 1e-6);
}

TEST_F(State, ShowsWhatTheDepthCameraHits) {
  config_.depth_device.projection.extrinsics.x = 0.2;
  state_.emplace(config_);
  drive(0.0, 0.5);
  PseudoLaser laser;
  laser.size = 2;
  laser.bearing_step = 0.1F;
  laser.storage[0] = {PseudoBeam::Kind::kHit, 1.0F, 0.5F};
  laser.storage[1] = {PseudoBeam::Kind::kFree, 3.0F, 0.5F};
  state_->take(toMessage(laser, utime_), kNow);
  ASSERT_EQ(state_->depth().size(), 1U);
  EXPECT_NEAR(state_->depth()[0].x(), 1.69, 0.011);
}

TEST_F(State, LeavesOutAScanOfATimeWithoutPoses) {
  drive(0.0, 0.2);
  LaserScan scan;
  scan.push({2.0F, 0.0F, 0.0F});
  state_->take(toMessage(scan, utime_ - 60'000'000), kNow);
  EXPECT_THAT(state_->scan(), testing::IsEmpty());
  EXPECT_EQ(state_->serials().scan, 0U);
}

TEST_F(State, KeepsATrailOfBoundedLengthFromItsBeginning) {
  for (int i = 0; i < 20'000; ++i) pose(0.06 * i, 0.0, 0.0);
  EXPECT_LE(state_->trail().size(), DrivenPath::kLongestTrail);
  EXPECT_NEAR(state_->trail().front().x(), 0.0, 1e-9);
  EXPECT_NEAR(state_->trail().back().x(), 0.06 * 19'999, 1e-6);
}

TEST_F(State, AddsNothingToTheTrailWhileThePoseIsNotValid) {
  pose(0.0, 0.0, 0.0, 1, LocalisationState::kInitialising);
  pose(5.0, 0.0, 0.0, 1, LocalisationState::kLost);
  EXPECT_THAT(state_->trail(), testing::IsEmpty());
}

TEST_F(State, MarksLoopClosuresWhereTheRobotIs) {
  pose(1.0, 2.0, 0.0);
  health(4, 10.0);
  EXPECT_THAT(state_->closures(), testing::IsEmpty()) << "those before somebody looked have no place";
  health(5, 11.0);
  ASSERT_EQ(state_->closures().size(), 1U);
  EXPECT_EQ(state_->closures()[0].at, Eigen::Vector2d(1.0, 2.0));
  EXPECT_EQ(state_->closures()[0].total, 5);
  health(5, 12.0);
  EXPECT_EQ(state_->closures().size(), 1U);
  health(7, 1.0);  // another start of slamd
  EXPECT_EQ(state_->closures().size(), 1U);
  for (int i = 8; i < 1000; ++i) health(i, 1.0 + i);
  EXPECT_EQ(state_->closures().size(), WebState::kMostClosures);
}

TEST_F(State, BeginsAnewWithAnotherMap) {
  map_meta_t meta{};
  meta.map_id = 1;
  meta.resolution = 0.1;
  drive(0.0, 0.5);
  state_->take(meta, kNow);
  state_->take(MapLayer::kBoth, test::noisyTile(1, 0, 0, 1), kNow);
  ASSERT_EQ(state_->tiles().size(), 1U);
  pose(0.0, 0.0, 0.0, 2);
  EXPECT_EQ(state_->tiles().size(), 0U);
  EXPECT_EQ(state_->tiles().mapId(), 2);
  EXPECT_EQ(state_->tiles().resolution(), 0.1);
  EXPECT_EQ(state_->trail().size(), 1U) << "of the map before";
}

TEST_F(State, KeepsTilesThatCameBeforeTheFirstPose) {
  map_meta_t meta{};
  meta.map_id = 3;
  meta.resolution = 0.05;
  state_->take(meta, kNow);
  state_->take(MapLayer::kBoth, test::noisyTile(3, 0, 0, 1), kNow);
  pose(0.0, 0.0, 0.0, 3);
  EXPECT_EQ(state_->tiles().size(), 1U);
}

TEST_F(State, CountsWhatCannotBeAPose) {
  pose(std::nan(""), 0.0, 0.0);
  pose(1e300, 0.0, 0.0);
  pose(0.0, 0.0, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(state_->pose());
  EXPECT_EQ(state_->badMessages(), 3U);
}

TEST_F(State, ReportsSinceWhenSlamdIsSilent) {
  state_->begin(kNow);
  EXPECT_EQ(state_->silence(kNow + 5s), 5s);
  health(0, 1.0);
  EXPECT_EQ(state_->silence(kNow + 2s), 2s);
}

TEST_F(State, KeepsSinceWhenThePoseHasItsState) {
  pose(0.0, 0.0, 0.0);
  EXPECT_EQ(state_->sinceState(), 0) << "it may have it for hours";
  pose(0.0, 0.0, 0.0, 1, LocalisationState::kLost);
  const std::int64_t lost = utime_;
  pose(0.0, 0.0, 0.0, 1, LocalisationState::kLost);
  EXPECT_EQ(state_->sinceState(), lost);
}

TEST_F(State, GoesOnAfterTheClockWasSet) {
  drive(0.0, 0.5);
  utime_ -= 3'600'000'000;
  drive(0.5, 1.0);
  LaserScan scan;
  scan.push({2.0F, 0.0F, 0.0F});
  state_->take(toMessage(scan, utime_), kNow);
  EXPECT_EQ(state_->scan().size(), 1U);
}

}  // namespace
}  // namespace slam::web_state_test
