// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/board/board_emulator.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace slam::sim::board_emulator_test {
namespace {

using robolink::Command;
using Bytes = std::vector<std::uint8_t>;

class BoardEmulatorTest : public testing::Test {
 protected:
  explicit BoardEmulatorTest(const BaseKinematics& base = {}) : board_(base) { renew(0.0, 0.0); }

  void renew(double left, double right) {
    uptime_ += 0.020;
    board_.renew(left, right, {.gyro = {0.0F, 0.0F, 0.25F}, .accel = {0.0F, 0.0F, 9.8F}}, uptime_);
  }
  /// @return what the board sends for one request, as it is on the line
  Bytes bytesFor(Command command, std::span<const std::uint8_t> payload = {}) {
    Bytes request(robolink::kMaxFrame), out;
    request.resize(robolink::encodeFrame(robolink::kMaster, robolink::kSlave, command, payload, request));
    board_.receive(request, out);
    return out;
  }
  /// @return the answer's payload; nothing when there is no good answer of this command
  std::optional<Bytes> ask(Command command, std::span<const std::uint8_t> payload = {}) {
    robolink::Decoder decoder;
    std::optional<Bytes> answer;
    for (const std::uint8_t byte : bytesFor(command, payload)) {
      for (auto frame = decoder.push(byte); frame; frame = decoder.flush()) {
        if (frame->command == static_cast<std::uint8_t>(command)) {
          answer = Bytes(frame->payload.begin(), frame->payload.end());
        }
      }
    }
    return answer;
  }
  void greet() { bytesFor(Command::kShakingHands, robolink::encodeCoordinate({})); }
  robolink::MotorVector mileage() {
    const auto payload = ask(Command::kGetMotorMileage);
    const auto motors = payload ? robolink::parseMotorVector(*payload) : std::nullopt;
    return motors.value_or(robolink::MotorVector{NAN, NAN, NAN, NAN});
  }
  std::optional<robolink::Imu> imu() {
    const auto payload = ask(Command::kGetImu);
    return payload ? robolink::parseImu(*payload) : std::nullopt;
  }

  BoardEmulator board_;
  Bytes bytes_;
  double uptime_ = 0.0;  // [s]
};

const Bytes kEmptyHandshake{0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x00, 0x13};

TEST_F(BoardEmulatorTest, AsksForTheHandshakeWhateverItIsAsked) {
  for (const Command command : {Command::kGetImu, Command::kSetRobotSpeed, Command::kReadChassisParameters}) {
    EXPECT_EQ(bytesFor(command), kEmptyHandshake);
  }
  EXPECT_TRUE(bytesFor(Command::kShakingHands, Bytes(11)).empty());
  EXPECT_FALSE(board_.greeted()) << "a handshake of a wrong size is none";
  EXPECT_TRUE(bytesFor(Command::kShakingHands, robolink::encodeCoordinate({1.0F, 2.0F, 3.0F})).empty());
  EXPECT_TRUE(board_.greeted());
  EXPECT_EQ(board_.coordinate()->y, 2.0F);
}

TEST_F(BoardEmulatorTest, AcknowledgesWhatIsSetAndIgnoresWrongSizes) {
  greet();
  const Bytes acknowledgement{0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x0C, 0x1F};
  EXPECT_EQ(bytesFor(Command::kSetRobotSpeed, robolink::encodeCoordinate({0.2F, 0.0F, 0.5F})), acknowledgement);
  EXPECT_TRUE(bytesFor(Command::kSetRobotSpeed, Bytes(11)).empty());
  EXPECT_TRUE(bytesFor(Command::kSetSystemInfo, Bytes(36)).empty());
  EXPECT_FALSE(board_.told());
  EXPECT_FALSE(bytesFor(Command::kSetSystemInfo, robolink::encodeSystemInfo({})).empty());
  EXPECT_TRUE(board_.told());
}

TEST_F(BoardEmulatorTest, ReportsTheSpeedsAndItsChassis) {
  greet();
  renew(0.1, -0.2);
  const auto speeds = robolink::parseMotorVector(*ask(Command::kGetMotorSpeed));
  EXPECT_NEAR((*speeds)[0], -5.0, 1e-5);
  EXPECT_NEAR((*speeds)[1], -10.0, 1e-5);
  const auto chassis = robolink::parseChassis(*ask(Command::kReadChassisParameters));
  EXPECT_EQ(chassis->type, robolink::ChassisType::kDifferential2);
  EXPECT_FLOAT_EQ(chassis->wheel_radius, 0.0325F);
  EXPECT_FLOAT_EQ(chassis->body_radius, 0.10075F);
}

TEST_F(BoardEmulatorTest, StopsTheMotorsWhenNoCommandsCome) {
  greet();
  const auto drive = [&] { ask(Command::kSetRobotSpeed, robolink::encodeCoordinate({0.2F, 0.0F, 0.5F})); };
  drive();
  renew(0, 0);
  EXPECT_EQ(board_.drive().norm(), 0.0) << "one command does not start a robot that stands";
  for (int i = 0; i < 50; ++i) {
    if (i % 5 == 0) drive();
    renew(0, 0);
  }
  EXPECT_TRUE(board_.drive().isApprox(Eigen::Vector3d(0.2, 0.0, 0.5), 1e-6));
  int steps = 0;
  for (; board_.drive().norm() > 0.0 && steps < 100; ++steps) renew(0, 0);
  EXPECT_NEAR(steps * 0.020, 0.7, 0.1);
}

TEST_F(BoardEmulatorTest, CountsFromZeroWhenAskedTo) {
  greet();
  renew(3.0, 4.0);
  EXPECT_EQ(mileage()[1], 4.0F);
  EXPECT_TRUE(ask(Command::kClearCoordinateData));
  EXPECT_EQ(mileage()[1], 0.0F);
  renew(3.5, 4.25);
  EXPECT_EQ(mileage()[0], -0.5F);
}

class OmniBoard : public BoardEmulatorTest {
 protected:
  OmniBoard() : BoardEmulatorTest({BaseType::kMecanum4, 0.0485, 0.199}) {}
};

TEST_F(OmniBoard, CountsItsServosAsTheyTurn) {
  greet();
  board_.renew(std::array{1.0, -2.0, 3.0, -4.0}, {}, 0.04);
  EXPECT_EQ(mileage(), (robolink::MotorVector{1.0F, -2.0F, 3.0F, -4.0F}));
  EXPECT_EQ(robolink::parseChassis(*ask(Command::kReadChassisParameters))->type, robolink::ChassisType::kMecanum4);
}

// ---- Faults

TEST_F(BoardEmulatorTest, ResetForgetsHandshakeAndMileage) {
  greet();
  renew(5.0, 6.0);
  EXPECT_TRUE(board_.inject("reset", 1.0));
  EXPECT_EQ(bytesFor(Command::kGetMotorMileage), kEmptyHandshake);
  greet();
  EXPECT_EQ(mileage()[1], 0.0F);
  renew(5.5, 6.25);
  EXPECT_EQ(mileage()[0], -0.5F);
  EXPECT_EQ(mileage()[1], 0.25F);
}

TEST_F(BoardEmulatorTest, SilentAnswersNothing) {
  greet();
  EXPECT_TRUE(board_.inject("silent", 1.0));
  EXPECT_TRUE(bytesFor(Command::kGetImu).empty());
  EXPECT_TRUE(board_.inject("silent", 0.0));
  EXPECT_TRUE(imu());
}

TEST_F(BoardEmulatorTest, GarbageIsTheSameOfTheSameSeed) {
  BoardEmulator other;
  greet();
  other.receive(Bytes{0xFF, 0xFF, 0x01, 0x11, 0, 0x0D, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x1F}, bytes_);
  EXPECT_TRUE(board_.inject("garbage", 1.0) && other.inject("garbage", 1.0));
  const Bytes garbage = bytesFor(Command::kGetMotorMileage);
  other.receive(Bytes{0xFF, 0xFF, 0x01, 0x11, 0, 0x01, 0x10, 0x23}, bytes_);
  EXPECT_EQ(garbage.size(), robolink::kMotorVectorSize + robolink::kOverhead);
  EXPECT_EQ(garbage, bytes_);
  EXPECT_FALSE(imu());
  EXPECT_TRUE(board_.inject("garbage", 0.0));
  EXPECT_TRUE(imu());
}

TEST_F(BoardEmulatorTest, ChecksumsAreWrongAsOftenAsSet) {
  greet();
  EXPECT_TRUE(board_.inject("checksum", 3.0));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(imu());
  EXPECT_TRUE(imu());
}

TEST_F(BoardEmulatorTest, StuckRenewsNothingAndLosesNothing) {
  greet();
  renew(1.0, 2.0);
  const auto info = ask(Command::kGetSystemInfo);
  EXPECT_TRUE(board_.inject("stuck", 1.0));
  renew(3.0, 4.0);
  EXPECT_EQ(mileage()[1], 2.0F);
  EXPECT_EQ(ask(Command::kGetSystemInfo), info);
  EXPECT_TRUE(board_.inject("stuck", 0.0));
  renew(3.5, 4.5);
  EXPECT_EQ(mileage()[1], 4.5F);
}

TEST_F(BoardEmulatorTest, WrongWheelsDoNotJump) {
  greet();
  renew(10.0, 20.0);
  EXPECT_TRUE(board_.inject("wrong", 1.5));
  EXPECT_EQ(mileage()[1], 20.0F);
  renew(12.0, 22.0);
  EXPECT_EQ(mileage()[1], 23.0F);
  EXPECT_TRUE(board_.inject("wrong", 1.0));
  renew(13.0, 23.0);
  EXPECT_EQ(mileage()[1], 24.0F);
}

TEST_F(BoardEmulatorTest, GyroBiasAndOfflineImuShowWithTheNextValues) {
  greet();
  EXPECT_TRUE(board_.inject("gyro_wrong", 0.5));
  renew(0, 0);
  EXPECT_EQ(imu()->gyro[2], 0.75F);
  EXPECT_TRUE(board_.inject("imu_offline", 1.0));
  renew(0, 0);
  EXPECT_EQ(imu()->online & 1, 0);
}

TEST_F(BoardEmulatorTest, SlowAnswersComeLaterInOrder) {
  greet();
  EXPECT_TRUE(board_.inject("slow", 50.0));
  EXPECT_TRUE(bytesFor(Command::kGetMotorMileage).empty());
  EXPECT_TRUE(board_.inject("slow", 0.0));
  EXPECT_TRUE(bytesFor(Command::kGetImu).empty()) << "not before the one that is under way";
  Bytes out;
  board_.receive({}, uptime_ + 0.049, out);
  EXPECT_TRUE(out.empty());
  board_.receive({}, uptime_ + 0.051, out);
  EXPECT_EQ(out.size(), robolink::kMotorVectorSize + robolink::kImuSize + 2 * robolink::kOverhead);
  EXPECT_EQ(out[6], 16);
}

TEST_F(BoardEmulatorTest, RefusesUnknownFaults) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(board_.inject("", 1.0));
  EXPECT_FALSE(board_.inject("slower", 1.0));
  EXPECT_FALSE(board_.inject("silent", 2.0));
  EXPECT_FALSE(board_.inject("stuck", nan));
  EXPECT_FALSE(board_.inject("reset", nan));
  EXPECT_FALSE(board_.inject("checksum", -1.0));
  EXPECT_FALSE(board_.inject("checksum", 1.5));
  EXPECT_FALSE(board_.inject("slow", -1.0));
  EXPECT_FALSE(board_.inject("slow", 1e6));
  EXPECT_FALSE(board_.inject("wrong", std::numeric_limits<double>::infinity()));
  greet();
  EXPECT_TRUE(imu()) << "and none of them had an effect";
}

}  // namespace
}  // namespace slam::sim::board_emulator_test
