// SPDX-License-Identifier: BSD-3-Clause
#include "tools/faults/sensor_faults.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace slam::sensor_faults_test {
namespace {

const ImuSample kSample{.stamp = {}, .gyro = {0.1, -0.2, 0.5}, .accel = {0.3, 0.4, 9.8}};

TEST(ImuFault, NoneLeavesTheSample) {
  const ImuSample same = ImuFault{}.apply(kSample);
  EXPECT_EQ(same.gyro, kSample.gyro);
  EXPECT_EQ(same.accel, kSample.accel);
  EXPECT_TRUE(
      std::signbit(ImuFault{}.apply({.stamp = {}, .gyro = {0.0, 0.0, -0.0}}).gyro.z()));  // to the byte, in a log
}

TEST(ImuFault, UpsideDownTurnsTwoAxesOfBothSensors) {
  const ImuSample down = ImuFault{.down = true}.apply(kSample);
  EXPECT_EQ(down.gyro, (Eigen::Vector3d{0.1, 0.2, -0.5}));
  EXPECT_EQ(down.accel, (Eigen::Vector3d{0.3, -0.4, -9.8}));
}

TEST(ImuFault, ClipsWhatTheSensorFeelsWithItsOffset) {
  EXPECT_DOUBLE_EQ(ImuFault({.offset = 0.3}).apply(kSample).gyro.z(), 0.8);
  EXPECT_DOUBLE_EQ(ImuFault({.offset = 0.3, .clip = 0.6}).apply(kSample).gyro.z(), 0.6);
  EXPECT_DOUBLE_EQ(ImuFault({.offset = -3.0, .clip = 0.6}).apply(kSample).gyro.z(), -0.6);
}

TEST(ImuFault, GoesInStepsBeforeTheUnitIsWrong) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  EXPECT_NEAR(ImuFault({.step = kDegree}).apply(kSample).gyro.z(), 29.0 * kDegree, 1e-12);  // 28.6
  EXPECT_NEAR(ImuFault({.degrees = true}).apply(kSample).gyro.z(), 28.6479, 1e-4);
  EXPECT_NEAR(ImuFault({.step = kDegree, .degrees = true}).apply(kSample).gyro.z(), 29.0, 1e-12);
}

}  // namespace
}  // namespace slam::sensor_faults_test
