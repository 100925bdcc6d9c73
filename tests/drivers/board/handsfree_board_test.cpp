// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board/handsfree_board.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "drivers/board/handsfree_fixture.hpp"

namespace slam::handsfree_board_test {
namespace {

using std::chrono::milliseconds;
using test::FakeBoard;
using test::HandsfreeBoardTest;
using test::virtual_now;
using test::virtualNow;

TEST_F(HandsfreeBoardTest, AnswersTheHandshakeAndPollsWheelsAndImu) {
  ASSERT_TRUE(runUntil([&] { return wheels_.size() >= 20 && imu_.size() >= 20; }));
  EXPECT_EQ(fake_.handshakes, 1);
  EXPECT_TRUE(streaming());
  EXPECT_GE(driver_->wheelStatus().samples.load(), 20);
  EXPECT_GE(driver_->imuStatus().samples.load(), 20);
  EXPECT_GT(driver_->wheelStatus().last_sample_ns.load(), 0);
}

TEST_F(HandsfreeBoardTest, CountsBothWheelsPositiveDrivingForward) {
  ASSERT_TRUE(runUntilWheels(20));
  EXPECT_TRUE(wheels_.front().restarted) << "nothing to compare the first reading with";
  for (std::size_t i = 1; i < wheels_.size(); ++i) {
    EXPECT_FALSE(wheels_[i].restarted);
    const double left = wheels_[i].angles[0] - wheels_[i - 1].angles[0];
    EXPECT_GT(left, 0.009);
    EXPECT_NEAR(wheels_[i].angles[1] - wheels_[i - 1].angles[1], 2.0 * left, 1e-5);
  }
}

TEST_F(HandsfreeBoardTest, StampsSamplesShortlyBeforeTheyCome) {
  const Timestamp begin = virtualNow();
  ASSERT_TRUE(runUntil([&] { return wheels_.size() >= 20 && imu_.size() >= 20; }));
  const Timestamp end = virtualNow();
  const auto expectInOrder = [&](const auto& samples) {
    EXPECT_GE(samples.front().stamp, begin - milliseconds(20));
    EXPECT_LE(samples.back().stamp, end);
    for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_GT(samples[i].stamp, samples[i - 1].stamp);
  };
  expectInOrder(wheels_);
  expectInOrder(imu_);
}

TEST_F(HandsfreeBoardTest, HandsTheImuOnInItsUnits) {
  ASSERT_TRUE(runUntil([&] { return imu_.size() >= 5; }));
  for (const ImuSample& sample : imu_) {
    EXPECT_TRUE(sample.gyro.isApprox(Eigen::Vector3d(0.1, -0.2, 0.3), 1e-6));
    EXPECT_TRUE(sample.accel.isApprox(Eigen::Vector3d(0.5, -0.25, 9.78), 0.01));
  }
}

TEST_F(HandsfreeBoardTest, LearnsTheBattery) {
  EXPECT_EQ(driver_->battery(), 0.0F);
  ASSERT_TRUE(runUntil([&] { return driver_->battery() != 0.0F; }));
  EXPECT_EQ(driver_->battery(), 11.5F);
}

TEST_F(HandsfreeBoardTest, NeverWaitsInATick) {
  fake_.mute = true;
  driver_->tick();  // opens
  const Timestamp begin = monotonicNow();
  for (int i = 0; i < 1000; ++i) driver_->tick();
  EXPECT_LT(monotonicNow() - begin, std::chrono::seconds(1)) << "1000 ticks without an answer";
}

// ---- Handshake

TEST_F(HandsfreeBoardTest, SendsAResetBoardItsLastCoordinateAndTheTime) {
  driver_->setCoordinate(1.5, -2.25, 0.5);
  driver_->setLocalTimeOffset(std::chrono::seconds(1'795'272'599) - virtual_now.time_since_epoch());
  ASSERT_TRUE(runUntil([&] { return fake_.info.has_value(); }));
  EXPECT_EQ(fake_.told->x, 1.5F);
  EXPECT_EQ(fake_.told->y, -2.25F);
  EXPECT_EQ(fake_.told->z, 0.5F);
  EXPECT_EQ(fake_.info->local_time, (robolink::LocalTime{true, 2026, 11, 21, 6, 14, 49, 59}));
  driver_->setCoordinate(7.0, 8.0, -1.0);
  fake_.restart();
  ASSERT_TRUE(runUntil([&] { return fake_.handshakes == 2; }));
  EXPECT_EQ(fake_.told->x, 7.0F);
}

TEST_F(HandsfreeBoardTest, SendsNoTimeThatItDoesNotHave) {
  ASSERT_TRUE(runUntil([&] { return fake_.info.has_value(); }));
  EXPECT_FALSE(fake_.info->local_time.valid);
}

// ---- Chassis

TEST_F(HandsfreeBoardTest, FindsNothingWhenTheBoardAgrees) {
  make({.wheel_radius = 0.0325, .body_radius = 0.1592});
  ASSERT_TRUE(runUntil([&] { return driver_->wheelRadius() != 0.0F; }));
  EXPECT_EQ(driver_->wheelRadius(), 0.033F);
  EXPECT_EQ(driver_->bodyRadius(), 0.16F);
  EXPECT_FALSE(driver_->finding());
}

TEST_F(HandsfreeBoardTest, AllowsACalibrationOfFivePercent) {
  const auto findings = [this](double share) {
    make({.wheel_radius = 0.033 / share, .body_radius = 0.16 / share});
    EXPECT_TRUE(runUntil([&] { return driver_->wheelRadius() != 0.0F; }));
    return driver_->finding();
  };
  for (const double share : {1.04, 0.96}) EXPECT_FALSE(findings(share)) << share;
  for (const double share : {1.06, 0.94}) EXPECT_TRUE(findings(share)) << share;
}

struct Disagreement {
  HandsfreeConfig config;
  const char* word;
};
class Chassis : public HandsfreeBoardTest, public testing::WithParamInterface<Disagreement> {};

TEST_P(Chassis, ThatIsAnotherThanConfiguredIsReportedInWordsAndNotObeyed) {
  make(GetParam().config);
  ASSERT_TRUE(runUntil([&] { return static_cast<bool>(driver_->finding()); }));
  EXPECT_NE(driver_->finding().words().find(GetParam().word), std::string::npos) << driver_->finding().words();
  ASSERT_TRUE(runUntilWheels(3));
  EXPECT_TRUE(streaming());
}

INSTANTIATE_TEST_SUITE_P(Of, Chassis,
                         testing::Values(Disagreement{{.wheel_radius = 0.04}, "wheel radius"},
                                         Disagreement{{.body_radius = 0.1}, "half the track"},
                                         Disagreement{{.chassis = robolink::ChassisType::kMecanum4}, "type of base"}));

TEST_F(HandsfreeBoardTest, WorksWithABoardWithoutAChassis) {
  fake_.knows_chassis = false;
  ASSERT_TRUE(runUntil([&] { return wheels_.size() > 300; }));
  EXPECT_FALSE(driver_->finding());
  const std::int64_t unanswered = driver_->wheelStatus().rejects;
  EXPECT_EQ(unanswered, 3) << "asks in vain a few times, not for ever";
}

TEST_F(HandsfreeBoardTest, HandsTheServosOfAnOmniBaseOnAsTheyCount) {
  make({.chassis = robolink::ChassisType::kOmni3});
  fake_.step = {-0.01F, 0.02F, 0.03F, 0.0F};
  ASSERT_TRUE(runUntilWheels(3));
  EXPECT_EQ(wheels_.back().count, 3);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(wheels_.back().angles[i], static_cast<double>(fake_.mileage[i]));
}

TEST_F(HandsfreeBoardTest, FlipsTheLeftWheelsOfTwoAxles) {
  make({.chassis = robolink::ChassisType::kDifferential4});
  fake_.step = {-0.01F, 0.02F, -0.03F, 0.04F};
  ASSERT_TRUE(runUntilWheels(3));
  EXPECT_EQ(wheels_.back().count, 4);
  for (const double angle : wheels_.back().used()) EXPECT_GT(angle, 0.0);
}

TEST_F(HandsfreeBoardTest, HandsTheMeasuredSpeedsOn) {
  ASSERT_TRUE(runUntil([&] { return speeds_.size() >= 3; }));
  EXPECT_EQ(speeds_.back().speeds[0], 3.5);
  EXPECT_EQ(speeds_.back().speeds[1], 4.25);
}

// ---- Mileage

TEST_F(HandsfreeBoardTest, SetsCoarseCountersBackWhileTheRobotStands) {
  driver_->setCoordinate(3.0, 4.0, 0.5);
  fake_.mileage = {-9000.0F, 8900.0F, 0.0F, 0.0F};
  ASSERT_TRUE(runUntilWheels(200));
  EXPECT_EQ(fake_.clears, 0) << "not while driving";
  fake_.step = {};
  ASSERT_TRUE(runUntil([&] { return fake_.clears == 1 && fake_.handshakes == 2; }));
  EXPECT_EQ(fake_.told->x, 3.0F) << "the board's own odometry goes on";
  const std::size_t before = wheels_.size();
  ASSERT_TRUE(runUntilWheels(20));
  int restarts = 0;
  for (std::size_t i = before; i < wheels_.size(); ++i) restarts += wheels_[i].restarted ? 1 : 0;
  EXPECT_EQ(restarts, 1);
  EXPECT_EQ(wheels_.back().angles[0], 0.0);
  EXPECT_EQ(fake_.clears, 1);
}

TEST_F(HandsfreeBoardTest, DoesNotInsistWhereCountersCannotBeSetBack) {
  fake_.mileage = {-9000.0F, 8900.0F, 0.0F, 0.0F};
  fake_.step = {};
  fake_.obeys_clear = false;
  runFor(std::chrono::seconds(20));
  EXPECT_EQ(fake_.clears, 1);
}

// ---- Stamps

TEST_F(HandsfreeBoardTest, StampsWithWhatTheBoardTookNotWhenItCame) {
  make({.mileage_rate = 50.0, .imu_rate = 100.0});
  const Timestamp origin = virtual_now + std::chrono::microseconds(7300);
  constexpr Duration kImuPeriod = milliseconds(20), kWheelPeriod = milliseconds(50);
  fake_.step = {};
  fake_.renew = [&] {  // values that say when they were taken
    const auto count = [&](Duration period) { return static_cast<float>((virtual_now - origin) / period); };
    fake_.imu.gyro[0] = count(kImuPeriod);
    fake_.mileage[1] = count(kWheelPeriod) * 0.125F;
  };
  runFor(std::chrono::seconds(25));
  wheels_.clear();
  imu_.clear();
  runFor(std::chrono::seconds(25));
  std::vector<double> imu_errors, wheel_errors;  // [s]
  for (const ImuSample& sample : imu_) {
    const Timestamp taken = origin + static_cast<std::int64_t>(std::lround(sample.gyro[0])) * kImuPeriod;
    imu_errors.push_back(std::abs(toSeconds(sample.stamp - taken)));
  }
  for (const WheelAngles& reading : wheels_) {
    const Timestamp taken = origin + static_cast<std::int64_t>(std::lround(reading.angles[1] * 8.0)) * kWheelPeriod;
    wheel_errors.push_back(std::abs(toSeconds(reading.stamp - taken)));
  }
  for (auto* errors : {&imu_errors, &wheel_errors}) {
    ASSERT_GT(errors->size(), 400U);
    std::sort(errors->begin(), errors->end());
    EXPECT_LT((*errors)[errors->size() * 95 / 100], 0.001);
  }
}

TEST_F(HandsfreeBoardTest, ReadsNoWrongSpeedWhereAReadingsAgeCannotBeKnown) {
  constexpr double kSpeed = 2.5, kPeriod = 0.05;  // [rad/s], [s] of the board's renewals
  const Timestamp origin = virtual_now;
  fake_.step = {};
  fake_.renew = [&] {
    fake_.mileage[1] = static_cast<float>(kSpeed * kPeriod * std::floor(toSeconds(virtual_now - origin) / kPeriod));
  };
  for (int i = 0; i < 20; ++i) {  // never long enough to learn when the board renews
    runFor(milliseconds(700));
    fake_.line().unplug();
    runFor(milliseconds(410 + 7 * i));
    fake_.line().plug();
  }
  ASSERT_GT(wheels_.size(), 100U);
  for (std::size_t i = 1; i < wheels_.size(); ++i) {
    const double turned = wheels_[i].angles[1] - wheels_[i - 1].angles[1];
    EXPECT_NEAR(turned / toSeconds(wheels_[i].stamp - wheels_[i - 1].stamp), kSpeed, 0.7 * kSpeed) << i;
  }
}

// ---- Driving

class Driving : public HandsfreeBoardTest {
 protected:
  Driving() { make({.may_drive = true}); }
};

TEST_F(Driving, SendsAFreshCommandAtTenHertzAtLeast) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(driver_->command(0.2, 0.0, 0.5));
    runFor(milliseconds(100));
  }
  ASSERT_GE(fake_.drives.size(), 50U);
  for (std::size_t i = 1; i < fake_.drives.size(); ++i) {
    EXPECT_LE(fake_.drives[i].when - fake_.drives[i - 1].when, milliseconds(100));
  }
  EXPECT_EQ(fake_.drives.back().speed.x, 0.2F);
  EXPECT_EQ(fake_.drives.back().speed.z, 0.5F);
  EXPECT_TRUE(streaming());
}

TEST_F(Driving, SendsZeroOnceAndThenNothingWhenCommandsStop) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  driver_->command(0.2, 0.0, 0.5);
  const Timestamp commanded = virtual_now;
  runFor(std::chrono::seconds(5));
  ASSERT_GE(fake_.drives.size(), 3U);
  EXPECT_EQ(fake_.drives.back().speed.x, 0.0F);
  EXPECT_LE(fake_.drives.back().when - commanded, milliseconds(700));
  const FakeBoard::Drive& last_moving = fake_.drives[fake_.drives.size() - 2];
  EXPECT_EQ(last_moving.speed.x, 0.2F);
  EXPECT_LE(last_moving.when - commanded, milliseconds(510));
}

TEST_F(Driving, StopsTheRobotWhenItIsStopped) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  driver_->command(0.2, 0.0, 0.0);
  runFor(milliseconds(200));
  ASSERT_FALSE(fake_.drives.empty());
  EXPECT_EQ(fake_.drives.back().speed.x, 0.2F);
  driver_->stop();
  fake_.serve();
  EXPECT_EQ(fake_.drives.back().speed.x, 0.0F);
}

TEST_F(Driving, SendsWhatIsTooFastSlowerOnTheSameCurve) {
  make({.may_drive = true, .limits = {.max_speed = 0.5, .max_turn_rate = 1.0}});
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  for (const double much : {1e300, 1e6, 50.0, 0.6}) {
    driver_->command(much, -much, 4.0 * much);
    runFor(milliseconds(200));
    const auto& speed = fake_.drives.back().speed;
    EXPECT_FLOAT_EQ(speed.x, 0.25F) << much;
    EXPECT_FLOAT_EQ(speed.y, -0.25F);
    EXPECT_FLOAT_EQ(speed.z, 1.0F);
  }
  EXPECT_EQ(driver_->limitedSpeeds(), 4U);
}

TEST_F(Driving, NeverSendsWhatIsNotANumber) {
  EXPECT_FALSE(driver_->command(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));
  EXPECT_FALSE(driver_->command(0.0, 0.0, std::numeric_limits<double>::infinity()));
  runFor(std::chrono::seconds(1));
  EXPECT_EQ(fake_.drives.size(), 1U) << "the stop that is owed at first";
}

TEST_F(HandsfreeBoardTest, DrivesNothingUnlessAllowed) {
  EXPECT_FALSE(driver_->command(0.2, 0.0, 0.0));
  runFor(std::chrono::seconds(1));
  EXPECT_TRUE(fake_.drives.empty());
}

}  // namespace
}  // namespace slam::handsfree_board_test
