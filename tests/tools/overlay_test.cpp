// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/overlay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "support/simulated/room.hpp"
#include "tools/files.hpp"

namespace slam::overlay_test {
namespace {

using test::Folder;
using test::refusalOf;
using testing::HasSubstr;

constexpr std::int64_t kStart = 1'700'000'000'000'000;
constexpr int kScans = 100;
constexpr double kPeriod = 0.2;  // [s]

/// Stands still for four seconds, goes 1.5 m away and comes back at the very end, 0.3 m off and a little turned.
Pose2 truthAt(int scan) {
  if (scan < 20) return {};
  if (scan < 50) return {0.05 * (scan - 20), 0.0, 0.0};
  if (scan < 80) return {1.5, 0.0, 0.0};
  return {1.5 - 0.06 * (scan - 80), 0.3, 0.1};
}

class Overlay : public testing::Test {
 protected:
  /// @param T_last shifts the last quarter of the trajectory, as drift does
  void write(const Pose2& T_last, double range_sigma = 0.01) {
    std::mt19937 random(3);
    const test::Room room{.length = 8.0, .width = 5.0, .range_sigma = range_sigma};
    EventLogWriter log(folder_ / "log.lcm");
    trajectory_.clear();
    for (int i = 0; i < kScans; ++i) {
      const std::int64_t utime = kStart + static_cast<std::int64_t>(1e6 * kPeriod) * i;
      log.writeMessage(utime, channel::kScan, toMessage(room.scan(truthAt(i), random), utime));
      trajectory_.push_back({fromMicroseconds(utime), i < 75 ? truthAt(i) : T_last * truthAt(i)});
    }
    log.flush();
  }
  OverlayErrors errors(const OverlayOptions& options = {}) const {
    return overlayVisits(trajectory_, folder_ / "log.lcm", Config{}, options);
  }

  Folder folder_;
  Trajectory trajectory_;
};

TEST_F(Overlay, IsAsGoodAsTheRangesWhereTheTrajectoryIsTrue) {
  write({});
  const OverlayErrors e = errors();
  EXPECT_LT(e.mean, 0.010);  // 0.8 sigma
  EXPECT_GT(e.paired, 0.95);
  EXPECT_EQ(e.first_scans, 25) << "of the first five seconds";
  EXPECT_EQ(e.last_scans, 10) << "nearer than a metre";
  EXPECT_EQ(e.points, 10 * 360);
}

TEST_F(Overlay, ShowsByHowMuchTheLastVisitIsOff) {
  write({0.05, 0.05, 0.0}, 0.002);
  EXPECT_NEAR(errors().mean, 0.05, 0.005);
  write({0.0, 0.5, 0.0}, 0.002);
  EXPECT_LT(errors().paired, 0.6) << "beyond the gate there is no pair";
}

TEST_F(Overlay, TakesNoVisitBeforeTheRobotLeftAndNoneBeforeHalfOfTheLog) {
  write({});
  OverlayOptions options;
  options.distance = 2.0;
  EXPECT_THAT(refusalOf([&] { errors(options); }), HasSubstr("never leaves"));
  trajectory_.resize(60);
  EXPECT_THAT(refusalOf([&] { errors(); }), HasSubstr("does not come back"));
  options = {};
  options.rotation = 0.05;
  write({});
  EXPECT_THAT(refusalOf([&] { errors(options); }), HasSubstr("does not come back")) << "turned too far";
}

TEST_F(Overlay, RefusesATrajectoryOfAnotherTime) {
  write({});
  for (StampedPose& row : trajectory_) row.stamp += std::chrono::hours(1);
  EXPECT_THAT(refusalOf([&] { errors(); }), HasSubstr("no scan of the log"));
}

}  // namespace
}  // namespace slam::overlay_test
