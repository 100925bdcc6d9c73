// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/board/handsfree_board.hpp"
#include "drivers/pseudo_terminal.hpp"
#include "drivers/virtual_time.hpp"

namespace slam::test {

using robolink::Command;
using std::chrono::milliseconds;

/// The board's side of the link, byte-exact: DEVICES.md 2.4. Served in turn with the driver, in one thread.
class FakeBoard {
 public:
  const std::string& path() const { return line_.path(); }
  PseudoTerminal& line() { return line_; }

  /// Answers what was sent.
  void serve() {
    if (!line_.plugged()) return;
    for (const std::uint8_t byte : line_.received()) {
      if (const auto frame = decoder_.push(byte)) take(*frame);
    }
    while (!answers_.empty() && answers_.front().due <= virtual_now) {
      line_.write(answers_.front().bytes);
      answers_.pop_front();
    }
    if (babble) line_.write(Bytes{0x12, 0xFF, 0xFF, 0x34, 0x56, 0x78});
  }
  /// Brown-out: forgets the handshake and its counts.
  void restart() {
    shaken_ = false;
    mileage = {};
  }

  bool mute = false, babble = false;
  bool answers = true;                                      ///< false: it obeys, but what it answers is lost
  int lost_speeds = 0;                                      ///< so many SET_ROBOT_SPEED do not arrive
  robolink::Coordinate speed = {};                          ///< that it drives at: the last it was given, for ever
  robolink::MotorVector step{-0.010F, 0.020F, 0.0F, 0.0F};  ///< [rad] between two answers; left counts negative
  robolink::MotorVector mileage{};                          ///< [rad]
  robolink::Imu imu{.online = 1, .gyro = {0.1F, -0.2F, 0.3F}, .accel = {0.5F, -0.25F, 9.75F}};
  std::function<void()> renew;  ///< called before each answer, in place of the steps above
  robolink::ChassisParameters chassis{.wheel_radius = 0.033F, .body_radius = 0.16F};
  bool time_runs = true, obeys_clear = true, knows_chassis = true;
  Bytes before_answers;  ///< noise on the line
  Duration delay{};      ///< from a request to its answer
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
        if (lost_speeds > 0) {
          --lost_speeds;
          return;
        }
        if (const auto wanted = robolink::parseCoordinate(frame.payload)) {
          speed = *wanted;
          drives.push_back({virtual_now, speed});
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
    if (!answers) return;
    std::array<std::uint8_t, robolink::kMaxFrame> frame{};
    const auto size = robolink::encodeFrame(robolink::kSlave, robolink::kMaster, command, payload, frame);
    Bytes bytes = before_answers;
    bytes.insert(bytes.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size));
    if (delay > Duration::zero()) return answers_.push_back({virtual_now + delay, std::move(bytes)});
    line_.write(bytes);
  }

  struct Answer {
    Timestamp due;
    Bytes bytes;
  };
  std::deque<Answer> answers_;  // that are on their way
  PseudoTerminal line_;
  robolink::Decoder decoder_{robolink::kSlave, robolink::kMaster};
  bool shaken_ = false;
  float system_time_ = 0.0F;  // [us]
};

class HandsfreeBoardTest : public testing::Test {
 protected:
  /// Ticks driver and board by turns until the condition holds. @return false when it did not within 30 s
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition) {
    const auto step = [this] {
      driver_->tick();
      note(driver_->wheelStatus(), wheel_states_);
      note(driver_->imuStatus(), imu_states_);
      fake_.serve();
    };
    return tickUntil(step, condition);
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
    EXPECT_TRUE(state == DeviceState::kStreaming || status.problem()) << "no words for what is wrong";
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
                              .speeds = [this](const WheelSpeeds& speeds) { speeds_.push_back(speeds); }},
        fake_.line().opener());
  }
  HandsfreeBoardTest() { make({.mileage_rate = 80.0, .imu_rate = 100.0}); }

  FakeBoard fake_;
  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  std::vector<WheelSpeeds> speeds_;
  std::vector<DeviceState> wheel_states_, imu_states_;
  std::unique_ptr<HandsfreeBoard> driver_;
};

}  // namespace slam::test
