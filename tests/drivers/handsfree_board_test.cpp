// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/handsfree_board.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "drivers/pseudo_terminal.hpp"

namespace slam {
namespace {

using robolink::Command;
using std::chrono::milliseconds;
using test::Bytes;

/// Time that passes only when a test says so.
Timestamp virtual_now{std::chrono::seconds(1000)};
Timestamp virtualNow() { return virtual_now; }

/// The board's side of the link, byte-exact: DEVICES.md 2.4. Served in turn with the driver, in one thread.
class FakeBoard {
 public:
  const std::string& path() const { return line_.path(); }
  test::PseudoTerminal& line() { return line_; }

  /// Answers what has come; waits up to a millisecond for it.
  void serve() {
    if (!line_.plugged()) return;
    for (const std::uint8_t byte : line_.read(milliseconds(1))) {
      if (const auto frame = decoder_.push(byte)) take(*frame);
    }
    if (babble) line_.write(Bytes{0x12, 0xFF, 0xFF, 0x34, 0x56, 0x78});
  }
  /// Brown-out: forgets the handshake and its counts.
  void restart() {
    shaken_ = false;
    mileage = {};
  }

  bool mute = false, babble = false;
  robolink::MotorVector step{-0.010F, 0.020F, 0.0F, 0.0F};  ///< [rad] between two answers; left counts negative
  robolink::MotorVector mileage{};                          ///< [rad]
  robolink::Imu imu{.online = 1, .gyro = {0.1F, -0.2F, 0.3F}, .accel = {0.5F, -0.25F, 9.75F}};
  std::function<void()> renew;  ///< called before each answer, in place of the steps above
  robolink::ChassisParameters chassis{.wheel_radius = 0.033F, .body_radius = 0.16F};
  bool time_runs = true, obeys_clear = true, knows_chassis = true;
  Bytes before_answers;  ///< noise on the line
  int handshakes = 0, clears = 0;
  std::optional<robolink::Coordinate> told;
  std::optional<robolink::SystemInfo> info;
  struct Drive {
    Timestamp when;
    robolink::Coordinate speed;
  };
  std::vector<Drive> drives;

 private:
  void take(const robolink::Frame& frame) {
    if (mute) return;
    const auto command = static_cast<Command>(frame.command);
    if (command == Command::kShakingHands) {  // stored, not acknowledged
      told = robolink::parseCoordinate(frame.payload);
      EXPECT_TRUE(told);
      shaken_ = told.has_value();
      ++handshakes;
      return;
    }
    if (!shaken_) return answer(Command::kShakingHands, {});
    if (renew) renew();
    switch (command) {
      case Command::kGetMotorMileage:
        for (std::size_t i = 0; i < 4; ++i) mileage[i] += step[i];
        return answer(command, robolink::encodeMotorVector(mileage));
      case Command::kGetMotorSpeed:
        return answer(command, robolink::encodeMotorVector({-3.5F, 4.25F, 0.0F, 0.0F}));
      case Command::kGetImu:
        if (!renew)
          imu.accel[2] += imu.accel[2] > 9.8F ? -0.01F : 0.01F;  // a real sensor never repeats itself for long
        return answer(command, robolink::encodeImu(imu));
      case Command::kGetSystemInfo:
        if (time_runs) system_time_ = static_cast<float>(1e6 * toSeconds(virtual_now.time_since_epoch()));
        return answer(command, robolink::encodeSystemInfo({.system_time = system_time_, .battery = 11.5F}));
      case Command::kReadChassisParameters:
        if (knows_chassis) answer(command, robolink::encodeChassis(chassis));
        return;
      case Command::kSetSystemInfo:
        info = robolink::parseSystemInfo(frame.payload);
        if (info) answer(command, {});
        return;
      case Command::kSetRobotSpeed:
        if (const auto speed = robolink::parseCoordinate(frame.payload)) {
          drives.push_back({virtual_now, *speed});
          answer(command, {});
        }
        return;
      case Command::kClearCoordinateData:
        ++clears;
        if (obeys_clear) mileage = {};
        return answer(command, {});
      default:
        FAIL() << "the host asks for " << int{frame.command};
    }
  }
  void answer(Command command, std::span<const std::uint8_t> payload) {
    std::array<std::uint8_t, robolink::kMaxFrame> frame{};
    const auto size = robolink::encodeFrame(robolink::kSlave, robolink::kMaster, command, payload, frame);
    line_.write(before_answers);
    line_.write(std::span(frame).first(size));
    line_.awaitDelivery();
  }

  test::PseudoTerminal line_;
  robolink::Decoder decoder_{robolink::kSlave, robolink::kMaster};
  bool shaken_ = false;
  float system_time_ = 0.0F;  // [us]
};

class HandsfreeBoardTest : public testing::Test {
 protected:
  /// Ticks driver and board by turns until the condition holds. @return false when it did not within 30 s
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition) {
    const Timestamp deadline = virtual_now + std::chrono::seconds(30);
    while (!condition()) {
      if (virtual_now > deadline) return false;
      virtual_now += kTick;
      driver_->tick();
      note(driver_->wheelStatus(), wheel_states_);
      note(driver_->imuStatus(), imu_states_);
      fake_.serve();
    }
    return true;
  }
  void runFor(Duration time) {
    const Timestamp end = virtual_now + time;
    ASSERT_TRUE(runUntil([&] { return virtual_now >= end; }));
  }
  [[nodiscard]] bool runUntilWheels(std::size_t more) {
    return runUntil([&, count = wheels_.size() + more] { return wheels_.size() >= count; });
  }
  static void note(const DeviceStatus& status, std::vector<DeviceState>& states) {
    const DeviceState state = status.state;
    if (states.empty() || states.back() != state) states.push_back(state);
    EXPECT_TRUE(state == DeviceState::kStreaming || status.reason.load()[0] != 0) << "no words for what is wrong";
  }
  bool streaming() {
    return driver_->wheelStatus().state == DeviceState::kStreaming &&
           driver_->imuStatus().state == DeviceState::kStreaming;
  }
  bool faulty() {
    return driver_->wheelStatus().state == DeviceState::kFault && driver_->imuStatus().state == DeviceState::kFault;
  }
  void make(HandsfreeConfig config) {
    config.port = fake_.path();
    driver_ = std::make_unique<HandsfreeBoard>(
        config, virtualNow,
        HandsfreeBoard::Sinks{.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); },
                              .imu = [this](const ImuSample& sample) { imu_.push_back(sample); },
                              .speeds = [this](const WheelSpeeds& speeds) { speeds_.push_back(speeds); }});
  }
  HandsfreeBoardTest() { make({.mileage_rate = 80.0, .imu_rate = 100.0}); }

  static constexpr Duration kTick = std::chrono::nanoseconds(1'000'000'000 / 211);
  FakeBoard fake_;
  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  std::vector<WheelSpeeds> speeds_;
  std::vector<DeviceState> wheel_states_, imu_states_;
  std::unique_ptr<HandsfreeBoard> driver_;
};

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
    EXPECT_NEAR(wheels_[i].angles[0] - wheels_[i - 1].angles[0], 0.010, 1e-5);
    EXPECT_NEAR(wheels_[i].angles[1] - wheels_[i - 1].angles[1], 0.020, 1e-5);
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

TEST_F(HandsfreeBoardTest, MarksTheFirstReadingAfterABoardReset) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.restart();
  ASSERT_TRUE(runUntilWheels(10));
  EXPECT_EQ(fake_.handshakes, 2);
  EXPECT_TRUE(wheels_[before].restarted);
  EXPECT_NEAR(wheels_[before].angles[0], 0.010, 1e-5) << "counts from zero again";
  for (std::size_t i = before + 1; i < wheels_.size(); ++i) EXPECT_FALSE(wheels_[i].restarted);
}

TEST_F(HandsfreeBoardTest, UsesAnswersBetweenNoise) {
  fake_.before_answers = {0xFF, 0x00, 0x55, 0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x10, 0xAA, 0xFF};
  ASSERT_TRUE(runUntilWheels(10));
  EXPECT_TRUE(runUntil([&] { return imu_.size() >= 10; }));
  EXPECT_GT(driver_->wheelStatus().rejects.load() + driver_->imuStatus().rejects.load(), 0) << "damage is counted";
}

TEST_F(HandsfreeBoardTest, RejectsAReadingThatIsNotANumber) {
  fake_.imu.gyro[1] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(runUntilWheels(10));
  ASSERT_TRUE(runUntil([&] { return driver_->imuStatus().rejects.load() > 0; }));
  EXPECT_TRUE(imu_.empty());
}

TEST_F(HandsfreeBoardTest, HasNoImuWhenTheUnitIsOffline) {
  fake_.imu.online = 0;
  ASSERT_TRUE(runUntilWheels(30));
  EXPECT_TRUE(imu_.empty());
  EXPECT_NE(driver_->imuStatus().state.load(), DeviceState::kStreaming);
  EXPECT_EQ(driver_->wheelStatus().state.load(), DeviceState::kStreaming);
}

TEST_F(HandsfreeBoardTest, ThatFallsSilentIsStaleThenAFaultThenUsedAgain) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  wheel_states_.clear(), imu_states_.clear();
  fake_.mute = true;
  ASSERT_TRUE(runUntil([&] { return faulty(); }));
  for (const auto& states : {wheel_states_, imu_states_}) {
    const auto stale = std::find(states.begin(), states.end(), DeviceState::kStale);
    EXPECT_NE(std::find(stale, states.end(), DeviceState::kFault), states.end());
  }
  fake_.mute = false;
  const auto wheels = wheels_.size(), imu = imu_.size();
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > wheels && imu_.size() > imu; }));
}

TEST_F(HandsfreeBoardTest, ThatNeverAnswersBecomesAFaultAndIsUsedWhenItDoes) {
  fake_.mute = true;
  ASSERT_TRUE(runUntil([&] { return faulty(); }));
  EXPECT_TRUE(wheels_.empty());
  fake_.mute = false;
  ASSERT_TRUE(runUntil([&] { return streaming() && !wheels_.empty() && !imu_.empty(); }));
  EXPECT_TRUE(wheels_.front().restarted);
}

TEST_F(HandsfreeBoardTest, NoticesAHangUpAndTheReturnOfTheDevice) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  fake_.line().unplug();
  fake_.restart();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state != DeviceState::kStreaming; }));
  EXPECT_NE(driver_->imuStatus().state.load(), DeviceState::kStreaming);
  const std::size_t before = wheels_.size();
  fake_.line().plug();
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > before; }));
  EXPECT_TRUE(wheels_[before].restarted);
}

TEST_F(HandsfreeBoardTest, IsAbsentWithoutAPort) {
  fake_.line().unplug();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state != DeviceState::kOpening; }));
  for (int i = 0; i < 10; ++i) driver_->tick();
  EXPECT_EQ(driver_->wheelStatus().state.load(), DeviceState::kAbsent);
  EXPECT_EQ(driver_->imuStatus().state.load(), DeviceState::kAbsent);
  EXPECT_STRNE(driver_->wheelStatus().reason.load(), "");
}

TEST_F(HandsfreeBoardTest, NeverWaitsInATick) {
  fake_.mute = true;
  driver_->tick();  // opens
  const Timestamp begin = monotonicNow();
  for (int i = 0; i < 1000; ++i) driver_->tick();
  EXPECT_LT(monotonicNow() - begin, std::chrono::seconds(1)) << "1000 ticks without an answer";
}

// ---- Handshake

TEST_F(HandsfreeBoardTest, TellsAResetBoardItsLastCoordinateAndTheTime) {
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

TEST_F(HandsfreeBoardTest, TellsNoTimeThatItDoesNotKnow) {
  ASSERT_TRUE(runUntil([&] { return fake_.info.has_value(); }));
  EXPECT_FALSE(fake_.info->local_time.valid);
}

// ---- Chassis

TEST_F(HandsfreeBoardTest, FindsNothingWhenTheBoardAgrees) {
  make({.wheel_radius = 0.0325, .body_radius = 0.1592});
  ASSERT_TRUE(runUntil([&] { return driver_->wheelRadius() != 0.0F; }));
  EXPECT_EQ(driver_->wheelRadius(), 0.033F);
  EXPECT_EQ(driver_->bodyRadius(), 0.16F);
  EXPECT_STREQ(driver_->finding(), "");
  EXPECT_EQ(driver_->findings(), 0U);
}

struct Disagreement {
  HandsfreeConfig config;
  const char* word;
};
class Chassis : public HandsfreeBoardTest, public testing::WithParamInterface<Disagreement> {};

TEST_P(Chassis, ThatIsAnotherThanConfiguredIsSaidInWordsAndNotObeyed) {
  make(GetParam().config);
  ASSERT_TRUE(runUntil([&] { return driver_->findings() > 0; }));
  EXPECT_NE(std::string(driver_->finding()).find(GetParam().word), std::string::npos) << driver_->finding();
  ASSERT_TRUE(runUntilWheels(3));
  EXPECT_TRUE(streaming());
}

INSTANTIATE_TEST_SUITE_P(Of, Chassis,
                         testing::Values(Disagreement{{.wheel_radius = 0.04}, "wheel radius"},
                                         Disagreement{{.body_radius = 0.1}, "half the track"},
                                         Disagreement{{.chassis = robolink::ChassisType::kMecanum4}, "type of base"}));

TEST_F(HandsfreeBoardTest, WorksWithABoardThatDoesNotKnowItsChassis) {
  fake_.knows_chassis = false;
  ASSERT_TRUE(runUntil([&] { return wheels_.size() > 300; }));
  EXPECT_STREQ(driver_->finding(), "");
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

TEST_F(HandsfreeBoardTest, GoesOnCountingOverALostPort) {
  ASSERT_TRUE(runUntilWheels(10));
  fake_.line().unplug();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state == DeviceState::kAbsent; }));
  const std::size_t before = wheels_.size();
  fake_.line().plug();
  ASSERT_TRUE(runUntilWheels(1));
  EXPECT_FALSE(wheels_[before].restarted) << "the board kept its power: nothing was missed";
  EXPECT_EQ(fake_.handshakes, 1);
}

TEST_F(HandsfreeBoardTest, InventsNoMotionFromAJumpOfTheCounter) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.mileage[1] += 500.0F;
  ASSERT_TRUE(runUntilWheels(2));
  EXPECT_TRUE(wheels_[before].restarted);
  EXPECT_FALSE(wheels_[before + 1].restarted);
}

TEST_F(HandsfreeBoardTest, InventsNoMotionFromACounterThatIsNotANumber) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::int64_t rejects = driver_->wheelStatus().rejects;
  const std::size_t before = wheels_.size();
  fake_.mileage[1] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().rejects > rejects; }));
  EXPECT_EQ(wheels_.size(), before);
  fake_.mileage[1] = 0.25F;
  ASSERT_TRUE(runUntilWheels(1));
  EXPECT_TRUE(wheels_[before].restarted);
}

TEST_F(HandsfreeBoardTest, SurvivesMissedPollsWithoutLosingTheWay) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.mute = true;
  runFor(milliseconds(400));
  for (std::size_t i = 0; i < 4; ++i) fake_.mileage[i] += 30 * fake_.step[i];
  fake_.mute = false;
  ASSERT_TRUE(runUntilWheels(5));
  EXPECT_NEAR(wheels_.back().angles[0], -static_cast<double>(fake_.mileage[0]), 1e-6);
  for (std::size_t i = before; i < wheels_.size(); ++i) EXPECT_FALSE(wheels_[i].restarted);
}

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

TEST_F(Driving, NeverSendsWhatIsNotANumber) {
  EXPECT_FALSE(driver_->command(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));
  EXPECT_FALSE(driver_->command(0.0, 0.0, std::numeric_limits<double>::infinity()));
  runFor(std::chrono::seconds(1));
  EXPECT_TRUE(fake_.drives.empty());
}

TEST_F(HandsfreeBoardTest, DrivesNothingUnlessAllowed) {
  EXPECT_FALSE(driver_->command(0.2, 0.0, 0.0));
  runFor(std::chrono::seconds(1));
  EXPECT_TRUE(fake_.drives.empty());
}

// ---- What is wrong, in words and in time

struct Trouble {
  const char* name;
  std::function<void(FakeBoard&)> begin, end;
  const char* words;
};
class InTrouble : public HandsfreeBoardTest, public testing::WithParamInterface<Trouble> {};

TEST_P(InTrouble, SaysSoWithinASecondAndStreamsAgainWithinThree) {
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > 100; }));
  GetParam().begin(fake_);
  const Timestamp begin = virtual_now;
  ASSERT_TRUE(runUntil([&] { return driver_->imuStatus().state != DeviceState::kStreaming; }));
  EXPECT_LE(virtual_now - begin, std::chrono::seconds(1));
  EXPECT_STREQ(driver_->imuStatus().reason, GetParam().words);
  runFor(std::chrono::seconds(6));
  GetParam().end(fake_);
  const Timestamp end = virtual_now;
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  EXPECT_LE(virtual_now - end, std::chrono::seconds(3));
}

INSTANTIATE_TEST_SUITE_P(
    Of, InTrouble,
    testing::Values(Trouble{"Silence", [](FakeBoard& f) { f.mute = true; }, [](FakeBoard& f) { f.mute = false; },
                            "the board does not answer: check its power"},
                    Trouble{"Babble", [](FakeBoard& f) { f.mute = f.babble = true; },
                            [](FakeBoard& f) { f.mute = f.babble = false; },
                            "the board's answers cannot be read: check baud rate and cable"},
                    Trouble{"Unplugging", [](FakeBoard& f) { f.line().unplug(); },
                            [](FakeBoard& f) { f.line().plug(); }, "the port is gone: unplugged?"},
                    Trouble{"ImuOffline", [](FakeBoard& f) { f.imu.online = 0; },
                            [](FakeBoard& f) { f.imu.online = 1; }, "the board says that its IMU is offline"},
                    Trouble{"ImuStuck", [](FakeBoard& f) { f.renew = [] {}; }, [](FakeBoard& f) { f.renew = nullptr; },
                            "the board answers, but its IMU values never change"}),
    [](const auto& instance) { return instance.param.name; });

TEST_F(HandsfreeBoardTest, TakesNoStandingWheelsFromABoardThatRenewsNothing) {
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > 300; }));
  fake_.time_runs = false;
  fake_.step = {};
  fake_.renew = [] {};
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state != DeviceState::kStreaming; }));
  EXPECT_STREQ(driver_->wheelStatus().reason, "the board answers, but renews nothing any more: restart it");
  const std::size_t before = wheels_.size();
  runFor(std::chrono::seconds(5));
  EXPECT_EQ(wheels_.size(), before);
  fake_.time_runs = true;
  fake_.renew = nullptr;
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
}

}  // namespace
}  // namespace slam
