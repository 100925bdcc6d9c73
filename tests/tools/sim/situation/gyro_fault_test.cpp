// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/gyro_fault.hpp"

#include <gtest/gtest.h>

namespace slam::sim {
namespace {

constexpr ImuReading kReading{.gyro = {0.1, -0.2, 0.5}, .accel = {0.3, 0.4, 9.8}};

TEST(GyroFault, NoneLeavesTheReading) {
  const ImuReading same = GyroFault{}.apply(kReading);
  EXPECT_EQ(same.gyro, kReading.gyro);
  EXPECT_EQ(same.accel, kReading.accel);
  EXPECT_TRUE(
      std::signbit(GyroFault{}.apply({.gyro = {0.0, 0.0, -0.0}, .accel = {}}).gyro[2]));  // to the byte, in a log
}

TEST(GyroFault, UpsideDownTurnsTwoAxesOfBothSensors) {
  const ImuReading down = GyroFault{.down = true}.apply(kReading);
  EXPECT_EQ(down.gyro, (std::array<double, 3>{0.1, 0.2, -0.5}));
  EXPECT_EQ(down.accel, (std::array<double, 3>{0.3, -0.4, -9.8}));
}

TEST(GyroFault, ClipsWhatTheSensorFeelsWithItsOffset) {
  EXPECT_DOUBLE_EQ(GyroFault({.offset = 0.3}).apply(kReading).gyro[2], 0.8);
  EXPECT_DOUBLE_EQ(GyroFault({.offset = 0.3, .clip = 0.6}).apply(kReading).gyro[2], 0.6);
  EXPECT_DOUBLE_EQ(GyroFault({.offset = -3.0, .clip = 0.6}).apply(kReading).gyro[2], -0.6);
}

TEST(GyroFault, GoesInStepsBeforeTheUnitIsWrong) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  EXPECT_NEAR(GyroFault({.step = kDegree}).apply(kReading).gyro[2], 29.0 * kDegree, 1e-12);  // 28.6
  EXPECT_NEAR(GyroFault({.degrees = true}).apply(kReading).gyro[2], 28.6479, 1e-4);
  EXPECT_NEAR(GyroFault({.step = kDegree, .degrees = true}).apply(kReading).gyro[2], 29.0, 1e-12);
}

}  // namespace
}  // namespace slam::sim
