// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/history/day_history.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>

namespace slam::day_history_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
constexpr std::int64_t kStart = 1'700'000'000'000'000, kSecond = 1'000'000;

class History : public testing::Test {
 protected:
  /// Poses at 10 Hz for so many seconds, along x.
  void poses(double seconds, int state, double speed = 0.0) {
    for (int i = 0; i < static_cast<int>(10 * seconds); ++i) {
      utime_ += kSecond / 10;
      pose_estimate_t pose{};
      pose.utime = utime_;
      pose.map_id = 4;
      pose.state = static_cast<std::int8_t>(state);
      pose.x = x_ += speed / 10;
      pose.twist[0] = speed;
      history_.take(pose);
    }
  }
  void health(int lidar_state, const char* problem = nullptr, const char* device = "lidar") {
    health_t health{};
    health.utime = utime_;
    health.devices.resize(1);
    health.devices[0].name = "lidar";
    health.devices[0].state = static_cast<std::int8_t>(lidar_state);
    problems_t problems{};
    if (problem != nullptr) {
      problems.problems.resize(1);
      problems.problems[0].device = device;
      problems.problems[0].id = problem;
    }
    history_.take(health, problems);
  }
  std::vector<std::string> words() const {
    std::vector<std::string> list;
    for (const auto& one : history_.all())
      list.push_back(one.kind + " " + one.name + " " + std::to_string((one.end - one.begin) / kSecond));
    return list;
  }

  DayHistory history_;
  std::int64_t utime_ = kStart;
  double x_ = 0.0;
};

TEST_F(History, HoldsTheStatesOneAfterAnother) {
  EXPECT_EQ(history_.since(), 0);
  poses(5, 0);
  poses(20, 1);
  poses(7, 3);
  health(2, "lost", "pose");
  EXPECT_THAT(words(), ElementsAre("state initialising 5", "state localised 20", "state lost 6"));
  EXPECT_EQ(history_.all().back().problem->id, "lost");
  EXPECT_NEAR(static_cast<double>(history_.since() - kStart), 0.0, 1e6);
}

TEST_F(History, HoldsADriveWithItsWay) {
  poses(5, 1);
  poses(20, 1, 0.5);
  poses(5, 1);  // a stop on the way
  poses(20, 1, 0.5);
  poses(15, 1);
  const auto& drive = history_.ended().front();
  EXPECT_EQ(drive.kind, "drive");
  EXPECT_NEAR(drive.metres, 20.0, 0.2);
  EXPECT_NEAR(static_cast<double>(drive.end - drive.begin) / kSecond, 45.0, 0.5);
  EXPECT_THAT(history_.ended(), SizeIs(1));
}

TEST_F(History, HoldsADeviceThatWasAwayWithItsProblemAndThePlace) {
  poses(10, 1, 0.5);
  health(2);
  health(0);
  health(0, "port_gone");
  poses(4, 2, 0.5);
  health(0, "lidar_spins_up");
  health(2);
  const auto list = history_.ended();
  const auto away = std::find_if(list.begin(), list.end(), [](const auto& one) { return one.kind == "device"; });
  ASSERT_NE(away, list.end());
  EXPECT_EQ(away->name, "lidar");
  EXPECT_EQ(away->problem->id, "port_gone");
  EXPECT_NEAR(away->x, 5.0, 0.1);
  EXPECT_EQ(away->map_id, 4);
  EXPECT_EQ((away->end - away->begin) / kSecond, 4);
}

TEST_F(History, HoldsMarksAndTheSilenceOfSlamd) {
  poses(10, 1);
  history_.mark("hit the wall");
  utime_ += 60 * kSecond;
  poses(5, 1);
  EXPECT_THAT(words(), ElementsAre("mark hit the wall 0", "state localised 9", "state silent 60", "state localised 4"));
}

TEST_F(History, IsOfOneDayAndBounded) {
  poses(1, 1);
  utime_ += DayHistory::kPeriod + 10 * kSecond;
  poses(2, 2);
  EXPECT_EQ(history_.since(), utime_ - DayHistory::kPeriod);
  for (std::size_t i = 0; i < 2 * DayHistory::kMost; ++i) {
    poses(0.1, 1);
    poses(0.1, 2);
  }
  EXPECT_LE(history_.all().size(), DayHistory::kMost + 2);
  EXPECT_GT(history_.since(), kStart + DayHistory::kPeriod) << "what was forgotten is not in it";
  for (int i = 0; i < 1000; ++i) {
    health_t health{};
    health.utime = utime_;
    health.devices.resize(1);
    health.devices[0].name = "device " + std::to_string(i);
    history_.take(health, problems_t{});
  }
  EXPECT_LE(history_.all().size(), DayHistory::kMost + 16);
}

TEST_F(History, IgnoresWhatNoSlamdSends) {
  poses(5, 1);
  for (const std::int64_t utime : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::int64_t{0},
                                   std::numeric_limits<std::int64_t>::max()}) {
    health_t health{};
    health.utime = utime;
    history_.take(health, problems_t{});
    pose_estimate_t pose{};
    pose.utime = utime;
    history_.take(pose);
  }
  EXPECT_THAT(words(), ElementsAre("state localised 4"));
  health(0, std::string(60'000, 'x').c_str());
  for (const auto& one : history_.all()) EXPECT_FALSE(one.problem) << "too long to be kept 3000 times";
  DayHistory empty;
  empty.mark("before anything");
  EXPECT_THAT(empty.all(), IsEmpty());
}

TEST_F(History, BeginsAnewWhereTheClockWasSetBack) {
  poses(10, 1);
  utime_ -= 3600 * kSecond;
  poses(5, 1);
  EXPECT_THAT(words(), ElementsAre("state localised 4"));
  EXPECT_LT(history_.since(), kStart);
  const auto json = historyJson(history_);
  EXPECT_EQ(json["happenings"].size(), 1U);
  EXPECT_TRUE(json["happenings"][0]["problem"].is_null());
}

}  // namespace
}  // namespace slam::day_history_test
