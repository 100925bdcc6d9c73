// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/board/imu_emulator.hpp"

#include <gtest/gtest.h>

#include "drivers/imu/codec/witmotion_frames.hpp"
#include "firmware_if/hfi_imu.hpp"

namespace slam::sim::imu_emulator_test {
namespace {

using Framing = ImuEmulator::Framing;
using Bytes = std::vector<std::uint8_t>;
constexpr std::array kGyro{0.1, -0.2, 0.5};      // [rad/s]
constexpr std::array kAccel{0.0, 0.0, 9.80665};  // [m/s^2]

struct Reading {
  double turn_rate = 0.0;  // [rad/s] about z
  double gravity = 0.0;    // [g] along z, the unit's sign
  int frames = 0;
};

class ImuEmulatorTest : public testing::TestWithParam<Framing> {
 protected:
  Bytes bytes() {
    Bytes out;
    unit_.sample(kGyro, kAccel, out);
    return out;
  }
  Reading read() {
    Reading reading;
    hfi::A9Decoder a9;
    witmotion::Decoder b6;
    for (const std::uint8_t byte : bytes()) {
      a9.push(byte, [&](std::span<const std::uint8_t> frame) {
        ++reading.frames;
        if (const auto motion = hfi::parseA9Motion(frame)) {
          reading.turn_rate = static_cast<double>(motion->gyro[2]);
          reading.gravity = static_cast<double>(motion->accel[2]);
        }
      });
      b6.push(byte, [&](std::span<const std::uint8_t> bytes) {
        ++reading.frames;
        const witmotion::Frame frame = witmotion::parse(bytes);
        if (frame.type == witmotion::Type::kTurnRate)
          reading.turn_rate = frame.raw[2] * witmotion::kRadiansPerSecondPerCount;
        if (frame.type == witmotion::Type::kAcceleration)
          reading.gravity = frame.raw[2] * witmotion::kGravitiesPerCount;
      });
    }
    return reading;
  }
  int framesOfASet() const { return GetParam() == Framing::kA9 ? 2 : 4; }

  ImuEmulator unit_{GetParam()};
};

TEST_P(ImuEmulatorTest, SendsASetOfGoodFrames) {
  const Reading reading = read();
  EXPECT_EQ(reading.frames, framesOfASet());
  EXPECT_NEAR(reading.turn_rate, 0.5, 0.001);
  EXPECT_NEAR(reading.gravity, -1.0, 0.001);
}

TEST_P(ImuEmulatorTest, FailsAsSet) {
  EXPECT_TRUE(unit_.inject("wrong", -2.0));
  EXPECT_NEAR(read().turn_rate, -1.0, 0.001);
  EXPECT_TRUE(unit_.inject("stuck", 1.0));
  EXPECT_TRUE(unit_.inject("wrong", 1.0));
  EXPECT_NEAR(read().turn_rate, -1.0, 0.001);
  EXPECT_TRUE(unit_.inject("stuck", 0.0));
  EXPECT_NEAR(read().turn_rate, 0.5, 0.001);
  EXPECT_TRUE(unit_.inject("checksum", 1.0));
  EXPECT_EQ(read().frames, framesOfASet() - 1);
  EXPECT_EQ(read().frames, framesOfASet());
  const std::size_t size = bytes().size();
  EXPECT_TRUE(unit_.inject("garbage", 1.0));
  EXPECT_EQ(bytes().size(), size);
  EXPECT_EQ(read().frames, 0);
  EXPECT_TRUE(unit_.inject("silent", 1.0));
  EXPECT_TRUE(bytes().empty());
}

TEST_P(ImuEmulatorTest, RefusesUnknownFaults) {
  EXPECT_FALSE(unit_.inject("reset", 1.0));
  EXPECT_FALSE(unit_.inject("silent", 0.5));
  EXPECT_FALSE(unit_.inject("checksum", -1.0));
  EXPECT_EQ(read().frames, framesOfASet());
}

INSTANTIATE_TEST_SUITE_P(Of, ImuEmulatorTest, testing::Values(Framing::kA9, Framing::kB6));

}  // namespace
}  // namespace slam::sim::imu_emulator_test
