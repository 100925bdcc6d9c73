// SPDX-License-Identifier: BSD-3-Clause
// The sketch itself, with the pins, the clock and the serial port of a board that this computer plays.
#include <gtest/gtest.h>
#include <optional>

#include "firmware_if/slamd_base/slamd_base.ino"

namespace {

using arduino_board::board;

class Sketch : public testing::Test {
 protected:
  void SetUp() override {
    board = {};
    control = BaseControl(kGains);
    receiver = Receiver();
    encoder_counts[0] = 0;
    encoder_counts[1] = 0;
    last_step = last_gyro_start = 0;
    setup();
  }
  void send(const Speeds& speeds) {
    std::uint8_t frame[kLongestFrame];
    board.received.insert(board.received.end(), frame, frame + encodeSpeeds(speeds, frame));
  }
  /// Runs the loop each millisecond, with both encoders turning by so many edges of A in each.
  void runFor(int milliseconds, int left_edges = 0, int right_edges = 0) {
    for (int i = 0; i < milliseconds; ++i, board.micros += 1000) {
      turn(0, left_edges);
      turn(1, right_edges);
      loop();
    }
    Receiver host;
    for (const std::uint8_t byte : board.sent) {
      host.push(byte, [this](const std::uint8_t* frame) {
        State state;
        ASSERT_TRUE(parseState(frame, &state));
        states.push_back(state);
      });
    }
    EXPECT_EQ(host.damaged(), 0U);
    board.sent.clear();
  }
  /// @param edges of A; B is a quarter of a period behind it, or before it where they are negative
  void turn(int side, int edges) {
    for (; edges != 0; edges += edges > 0 ? -1 : 1) {
      const auto a = static_cast<std::uint8_t>(board.level[kEncoderA[side]] == LOW ? HIGH : LOW);
      board.level[kEncoderB[side]] = edges > 0 ? a : static_cast<std::uint8_t>(1 - a);
      board.set(kEncoderA[side], a);
    }
  }
  std::vector<State> states;
};

TEST_F(Sketch, SendsAHundredStatesASecondWithCountsThatGoUpForward) {
  EXPECT_EQ(Serial.rate, kBaud);
  board.gyro_digits = -1310;  // -10 degrees/s
  runFor(1000, 1, -2);
  ASSERT_NEAR(static_cast<double>(states.size()), 100.0, 2.0);
  EXPECT_NEAR(states.back().counts[0] - states.front().counts[0], 990, 15);
  EXPECT_NEAR(states.back().counts[1] - states.front().counts[1], -1980, 30);
  EXPECT_NEAR(states.back().turn_rate, -174533, 2);
  EXPECT_EQ(states.back().flags, kHasGyro);
  for (std::size_t i = 1; i < states.size(); ++i) EXPECT_NEAR(states[i].stamp - states[i - 1].stamp, 10000, 1000);
}

TEST_F(Sketch, DrivesByACommandAndStops200MillisecondsBehindTheLast) {
  runFor(100);
  EXPECT_EQ(board.pwm[kPwm[0]], 0);
  for (int i = 1; i <= 20; ++i) {
    send({static_cast<std::uint8_t>(i), {1500, -1500}});
    runFor(50);
  }
  EXPECT_EQ(states.back().speeds, 20);
  EXPECT_TRUE((states.back().flags & kDriven) != 0);
  EXPECT_GT(board.pwm[kPwm[0]], 100);
  EXPECT_EQ(board.level[kForward[0]], HIGH);
  EXPECT_EQ(board.level[kBackward[0]], LOW);
  EXPECT_EQ(board.level[kForward[1]], LOW);
  EXPECT_EQ(board.level[kBackward[1]], HIGH);
  runFor(140);
  EXPECT_GT(board.pwm[kPwm[0]], 0);
  runFor(25);
  for (int side = 0; side < 2; ++side) {
    EXPECT_EQ(board.pwm[kPwm[side]], 0);
    EXPECT_EQ(board.level[kForward[side]], LOW);
    EXPECT_EQ(board.level[kBackward[side]], LOW);
  }
  EXPECT_FALSE((states.back().flags & kDriven) != 0);
}

TEST_F(Sketch, StopsThoughNobodyReadsWhatItSends) {
  send({1, {1500, 1500}});
  runFor(50);
  board.room = 10;
  runFor(400);
  EXPECT_EQ(board.pwm[kPwm[0]], 0);
  const std::size_t before = states.size();
  board.room = 64;
  runFor(100);
  EXPECT_GT(states.size(), before) << "it goes on";
}

TEST_F(Sketch, ObeysNoDamagedCommand) {
  std::uint8_t frame[kLongestFrame];
  const std::uint8_t size = encodeSpeeds({5, {1500, 1500}}, frame);
  for (std::uint8_t at = 0; at < size; ++at) {
    for (std::uint8_t i = 0; i < size; ++i)
      board.received.push_back(static_cast<std::uint8_t>(i == at ? frame[i] ^ 0x10 : frame[i]));
    board.received.insert(board.received.end(), kLongestFrame, 0);
    runFor(20);
    EXPECT_EQ(board.pwm[kPwm[0]], 0) << static_cast<int>(at);
  }
  send({6, {1500, 1500}});
  runFor(20);
  EXPECT_GT(board.pwm[kPwm[0]], 0);
}

TEST_F(Sketch, NamesAGyroThatDoesNotAnswerAndFindsItAgain) {
  board.gyro = false;
  runFor(100);
  EXPECT_EQ(states.back().flags & kHasGyro, 0);
  EXPECT_EQ(states.back().turn_rate, 0);
  board.gyro = true;
  runFor(1100);
  EXPECT_EQ(states.back().flags & kHasGyro, kHasGyro);
}

}  // namespace
