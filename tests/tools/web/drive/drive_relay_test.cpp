// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/drive/drive_relay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <vector>

namespace slam::drive_relay_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

class Relay : public testing::Test {
 protected:
  std::string press(std::uint64_t hold, double vx) { return relay_.take({{vx, 0.0, 0.0}, hold}, now_).words(); }
  std::string stop(std::uint64_t hold = 0) { return press(hold, 0.0); }
  /// Time goes on as in the loop that calls tend().
  void pass(Duration time) {
    for (const Timestamp end = now_ + time; now_ < end;) {
      now_ += 10ms;
      relay_.tend(now_);
    }
  }

  Timestamp now_{100s};
  bool fails_ = false;
  std::vector<double> sent_;  // forwards
  DriveRelay relay_{[this](const Twist2& twist) {
    if (!fails_) sent_.push_back(twist.vx);
    return !fails_;
  }};
};

TEST_F(Relay, SendsEachSpeedOnce) {
  EXPECT_THAT(press(7, 0.3), IsEmpty());
  pass(80ms);
  EXPECT_THAT(press(7, 0.4), IsEmpty());
  EXPECT_THAT(stop(7), IsEmpty());
  pass(5s);
  EXPECT_EQ(sent_, (std::vector{0.3, 0.4, 0.0})) << "and nothing by itself";
}

TEST_F(Relay, StopsWhereThePageFallsSilent) {
  press(7, 0.3);
  const Timestamp began = now_;
  ASSERT_EQ(relay_.deadline(), began + DriveRelay::kLongestGap);
  while (sent_.size() < 2) pass(10ms);
  EXPECT_LE(now_ - began, 300ms);
  EXPECT_EQ(sent_, (std::vector{0.3, 0.0}));
  EXPECT_EQ(relay_.deadline(), std::nullopt);
}

TEST_F(Relay, DrivesNoneOfAPressThatHasEnded) {
  press(7, 0.3);
  stop(7);
  EXPECT_THAT(press(7, 0.3), HasSubstr("has ended")) << "it was late on its way";
  press(8, 0.2);
  pass(1s);
  EXPECT_THAT(press(8, 0.2), HasSubstr("has ended")) << "the link was lost, and is back";
  EXPECT_THAT(press(9, 0.1), IsEmpty());
  EXPECT_EQ(sent_, (std::vector{0.3, 0.0, 0.2, 0.0, 0.1}));
}

TEST_F(Relay, StopsForAPressWhoseZeroOvertookIt) {
  stop(7);
  EXPECT_THAT(press(7, 0.3), HasSubstr("has ended"));
  EXPECT_EQ(sent_, std::vector{0.0});
}

TEST_F(Relay, StopsForAnybody) {
  press(7, 0.3);
  EXPECT_THAT(stop(), IsEmpty());
  EXPECT_THAT(press(7, 0.3), HasSubstr("has ended"));
  EXPECT_EQ(sent_, (std::vector{0.3, 0.0}));
}

TEST_F(Relay, DrivesForOneAtATime) {
  press(7, 0.3);
  EXPECT_THAT(press(8, -0.3), HasSubstr("another page"));
  EXPECT_EQ(sent_, std::vector{0.3});
  pass(1s);
  EXPECT_THAT(press(8, -0.3), IsEmpty());
}

TEST_F(Relay, OwesAStopThatCouldNotBeSent) {
  press(7, 0.3);
  fails_ = true;
  EXPECT_THROW(stop(7), std::runtime_error);
  EXPECT_THROW(press(8, 0.3), std::runtime_error);
  pass(100ms);
  fails_ = false;
  pass(10ms);
  EXPECT_EQ(sent_, (std::vector{0.3, 0.0}));
  fails_ = true;
  EXPECT_THROW(press(9, 0.3), std::runtime_error) << "it may have been sent in part";
  fails_ = false;
  pass(10ms);
  EXPECT_EQ(sent_, (std::vector{0.3, 0.0, 0.0}));
}

TEST_F(Relay, StopsAtItsEnd) {
  relay_.end(now_);
  EXPECT_THAT(sent_, IsEmpty()) << "nothing was driven";
  EXPECT_THAT(press(6, 0.3), HasSubstr("ends"));
  DriveRelay driving([this](const Twist2& twist) { return sent_.push_back(twist.vx), true; });
  driving.take({{0.3, 0.0, 0.0}, 7}, now_);
  driving.end(now_);
  EXPECT_EQ(sent_, (std::vector{0.3, 0.0}));
}

TEST(DriveRequest, IsReadFromJson) {
  std::string problem;
  const auto drive = driveRequestOf(R"({"vx": 0.5, "vy": -0.1, "omega": -1, "hold": 1764366639123})", problem);
  ASSERT_TRUE(drive) << problem;
  EXPECT_EQ(drive->twist.vx, 0.5);
  EXPECT_EQ(drive->twist.vy, -0.1);
  EXPECT_EQ(drive->twist.omega, -1.0);
  EXPECT_EQ(drive->hold, 1'764'366'639'123U);
  EXPECT_TRUE(driveRequestOf(R"({"vx": 0, "omega": 0})", problem)) << "a stop needs no press";
}

TEST(DriveRequest, IsRefusedWithHostileNumbers) {
  for (const char* body : {"",
                           "{",
                           "[]",
                           "null",
                           "{}",
                           R"({"vx": 0.1, "hold": 1})",
                           R"({"vx": "0.1", "omega": 0, "hold": 1})",
                           R"({"vx": null, "omega": 0, "hold": 1})",
                           R"({"vx": NaN, "omega": 0, "hold": 1})",
                           R"({"vx": Infinity, "omega": 0, "hold": 1})",
                           R"({"vx": 1e999, "omega": 0, "hold": 1})",
                           R"({"vx": 1e300, "omega": 0, "hold": 1})",
                           R"({"vx": 10.1, "omega": 0, "hold": 1})",
                           R"({"vx": 0, "omega": -21, "hold": 1})",
                           R"({"vx": 0, "vy": [], "omega": 0, "hold": 1})",
                           R"({"vx": 0, "vy": -11, "omega": 0, "hold": 1})",
                           R"({"vx": 0.1, "omega": 0, "hold": -1})",
                           R"({"vx": 0.1, "omega": 0, "hold": 1.5})",
                           R"({"vx": 0.1, "omega": 0, "hold": "1"})",
                           R"({"vx": 0.1, "omega": 0, "hold": 18446744073709551615})",
                           R"({"vx": 0.1, "omega": 0, "hold": 0})",
                           R"({"vx": 0.1, "omega": 0})"}) {
    std::string problem;
    EXPECT_FALSE(driveRequestOf(body, problem)) << body;
    EXPECT_NE(problem, "") << body;
  }
}

}  // namespace
}  // namespace slam::drive_relay_test
