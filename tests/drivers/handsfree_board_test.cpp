// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/handsfree_board.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <limits>
#include <thread>
#include <vector>

#include "drivers/pseudo_terminal.hpp"

namespace slam {
namespace {

using robolink::Command;
using std::chrono::milliseconds;
using test::Bytes;

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
  }
  /// Brown-out: forgets the handshake and its counts.
  void restart() {
    shaken_ = false;
    mileage_ = {};
  }

  bool mute = false;
  robolink::MotorVector step{-0.010F, 0.020F, 0.0F, 0.0F};  ///< [rad] between two answers; left counts negative
  robolink::Imu imu{.online = 1, .gyro = {0.1F, -0.2F, 0.3F}, .accel = {0.5F, -0.25F, 9.75F}};
  Bytes before_answers;  ///< noise on the line
  int handshakes = 0;

 private:
  void take(const robolink::Frame& frame) {
    if (mute) return;
    const auto command = static_cast<Command>(frame.command);
    if (command == Command::kShakingHands) {  // stored, not acknowledged
      EXPECT_EQ(frame.payload.size(), robolink::kCoordinateSize);
      shaken_ = frame.payload.size() == robolink::kCoordinateSize;
      ++handshakes;
      return;
    }
    if (!shaken_) return answer(Command::kShakingHands, {});
    switch (command) {
      case Command::kGetMotorMileage:
        for (std::size_t i = 0; i < 4; ++i) mileage_[i] += step[i];
        return answer(command, robolink::encodeMotorVector(mileage_));
      case Command::kGetImu:
        imu.accel[2] += imu.accel[2] > 9.8F ? -0.01F : 0.01F;  // a real sensor never repeats itself for long
        return answer(command, robolink::encodeImu(imu));
      case Command::kGetSystemInfo:
        return answer(command, robolink::encodeSystemInfo({.battery = 11.5F}));
      default:
        return answer(command, {});
    }
  }
  void answer(Command command, std::span<const std::uint8_t> payload) {
    std::array<std::uint8_t, robolink::kMaxFrame> frame{};
    const auto size = robolink::encodeFrame(robolink::kSlave, robolink::kMaster, command, payload, frame);
    line_.write(before_answers);
    line_.write(std::span(frame).first(size));
  }

  test::PseudoTerminal line_;
  robolink::Decoder decoder_{robolink::kSlave, robolink::kMaster};
  bool shaken_ = false;
  robolink::MotorVector mileage_{};
};

class HandsfreeBoardTest : public testing::Test {
 protected:
  /// Ticks driver and board by turns until the condition holds. @return false when it did not in time
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition) {
    const Timestamp deadline = monotonicNow() + std::chrono::seconds(30);
    while (!condition()) {
      if (monotonicNow() > deadline) return false;
      driver_.tick();
      note(driver_.wheelStatus(), wheel_states_);
      note(driver_.imuStatus(), imu_states_);
      if (fake_.line().plugged()) {
        fake_.serve();
      } else {
        std::this_thread::sleep_for(milliseconds(1));
      }
    }
    return true;
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
    return driver_.wheelStatus().state == DeviceState::kStreaming &&
           driver_.imuStatus().state == DeviceState::kStreaming;
  }
  bool faulty() {
    return driver_.wheelStatus().state == DeviceState::kFault && driver_.imuStatus().state == DeviceState::kFault;
  }

  FakeBoard fake_;
  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  std::vector<DeviceState> wheel_states_, imu_states_;
  HandsfreeBoard driver_{{.port = fake_.path(), .mileage_rate = 100.0, .imu_rate = 100.0, .sample_age = 0.010},
                         monotonicNow,
                         {.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); },
                          .imu = [this](const ImuSample& sample) { imu_.push_back(sample); }}};
};

TEST_F(HandsfreeBoardTest, AnswersTheHandshakeAndPollsWheelsAndImu) {
  ASSERT_TRUE(runUntil([&] { return wheels_.size() >= 20 && imu_.size() >= 20; }));
  EXPECT_EQ(fake_.handshakes, 1);
  EXPECT_TRUE(streaming());
  EXPECT_GE(driver_.wheelStatus().samples.load(), 20);
  EXPECT_GE(driver_.imuStatus().samples.load(), 20);
  EXPECT_GT(driver_.wheelStatus().last_sample_ns.load(), 0);
}

TEST_F(HandsfreeBoardTest, CountsBothWheelsPositiveDrivingForward) {
  ASSERT_TRUE(runUntilWheels(20));
  EXPECT_TRUE(wheels_.front().restarted) << "nothing to compare the first reading with";
  for (std::size_t i = 1; i < wheels_.size(); ++i) {
    EXPECT_FALSE(wheels_[i].restarted);
    EXPECT_NEAR(wheels_[i].left - wheels_[i - 1].left, 0.010, 1e-5);
    EXPECT_NEAR(wheels_[i].right - wheels_[i - 1].right, 0.020, 1e-5);
  }
}

TEST_F(HandsfreeBoardTest, StampsSamplesShortlyBeforeTheyCome) {
  const Timestamp begin = monotonicNow();
  ASSERT_TRUE(runUntil([&] { return wheels_.size() >= 20 && imu_.size() >= 20; }));
  const Timestamp end = monotonicNow();
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
  EXPECT_EQ(driver_.battery(), 0.0F);
  ASSERT_TRUE(runUntil([&] { return driver_.battery() != 0.0F; }));
  EXPECT_EQ(driver_.battery(), 11.5F);
}

TEST_F(HandsfreeBoardTest, MarksTheFirstReadingAfterABoardReset) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.restart();
  ASSERT_TRUE(runUntilWheels(10));
  EXPECT_EQ(fake_.handshakes, 2);
  EXPECT_TRUE(wheels_[before].restarted);
  EXPECT_NEAR(wheels_[before].left, 0.010, 1e-5) << "counts from zero again";
  for (std::size_t i = before + 1; i < wheels_.size(); ++i) EXPECT_FALSE(wheels_[i].restarted);
}

TEST_F(HandsfreeBoardTest, UsesAnswersBetweenNoise) {
  fake_.before_answers = {0xFF, 0x00, 0x55, 0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x10, 0xAA, 0xFF};
  ASSERT_TRUE(runUntilWheels(10));
  EXPECT_TRUE(runUntil([&] { return imu_.size() >= 10; }));
  EXPECT_GT(driver_.wheelStatus().rejects.load() + driver_.imuStatus().rejects.load(), 0) << "damage is counted";
}

TEST_F(HandsfreeBoardTest, RejectsAReadingThatIsNotANumber) {
  fake_.imu.gyro[1] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(runUntilWheels(10));
  ASSERT_TRUE(runUntil([&] { return driver_.imuStatus().rejects.load() > 0; }));
  EXPECT_TRUE(imu_.empty());
}

TEST_F(HandsfreeBoardTest, HasNoImuWhenTheUnitIsOffline) {
  fake_.imu.online = 0;
  ASSERT_TRUE(runUntilWheels(30));
  EXPECT_TRUE(imu_.empty());
  EXPECT_NE(driver_.imuStatus().state.load(), DeviceState::kStreaming);
  EXPECT_EQ(driver_.wheelStatus().state.load(), DeviceState::kStreaming);
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
  ASSERT_TRUE(runUntil([&] { return driver_.wheelStatus().state != DeviceState::kStreaming; }));
  EXPECT_NE(driver_.imuStatus().state.load(), DeviceState::kStreaming);
  const std::size_t before = wheels_.size();
  fake_.line().plug();
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > before; }));
  EXPECT_TRUE(wheels_[before].restarted);
}

TEST_F(HandsfreeBoardTest, IsAbsentWithoutAPort) {
  fake_.line().unplug();
  ASSERT_TRUE(runUntil([&] { return driver_.wheelStatus().state != DeviceState::kOpening; }));
  for (int i = 0; i < 10; ++i) driver_.tick();
  EXPECT_EQ(driver_.wheelStatus().state.load(), DeviceState::kAbsent);
  EXPECT_EQ(driver_.imuStatus().state.load(), DeviceState::kAbsent);
  EXPECT_STRNE(driver_.wheelStatus().reason.load(), "");
}

TEST_F(HandsfreeBoardTest, NeverWaitsInATick) {
  fake_.mute = true;
  driver_.tick();  // opens
  const Timestamp begin = monotonicNow();
  for (int i = 0; i < 1000; ++i) driver_.tick();
  EXPECT_LT(monotonicNow() - begin, std::chrono::seconds(1)) << "1000 ticks without an answer";
}

}  // namespace
}  // namespace slam
