// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/gyro_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <utility>

#include "support/allocations.hpp"
#include "support/simulated/robot.hpp"

namespace slam::gyro_monitor_test {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kBiasError = 0.04;  // [rad/s] twice the sigma of a bias that is handed on

/// A robot that turns to and fro and rests between; gyro and wheels at 50 Hz, matched scans at 5 Hz.
struct Drive : test::SimulatedRobot {
  explicit Drive(unsigned seed = 1) : SimulatedRobot(test::Room{}, {0.0, 0.0, 3.0}, seed) {
    gyro.sigma = 0.0015;
    wheels.turn_sigma = 0.0005;
    wheels.pose.theta = -2.0;
    matches.sigma.z() = 0.001;
    lidar.ahead = 9;  // the first at once
  }

  double time = 0.0;  // [s]
  double bias = 0.0;  // [rad/s] of the filter
  GyroMonitor monitor{EkfConfig{}};
  int distrusted = 0, used_again = 0, withdrawn = 0;  // times
  ImuSample newest;

  /// @param fastest [rad/s] of the turns
  Drive& go(double seconds, double fastest = 0.8) {
    for (const Timestamp end = now + fromSeconds(seconds); now < end; time += toSeconds(kStep)) {
      step({0.0, 0.0, fastest * std::clamp(2.0 * std::sin(0.7 * time), -1.0, 1.0)}, *this);
    }
    return *this;
  }
  void add(const WheelSample& sample) { distrusted += monitor.add(sample, bias); }
  void add(const ImuSample& sample) { newest = monitor.add(sample); }
  void add(const PoseMeasurement& match) {
    const bool reliable = monitor.reliable();
    if (const auto learned = monitor.compare(now, match.T_map_base.theta, bias)) {
      bias = learned->value;
      ++used_again;
    }
    withdrawn += reliable && !monitor.reliable();
  }
  GyroVerdict verdict() const { return monitor.verdict(bias); }
  void expect(GyroReliability reliability, GyroFault fault) const {
    EXPECT_EQ(static_cast<int>(verdict().reliability), static_cast<int>(reliability));
    EXPECT_EQ(static_cast<int>(verdict().fault), static_cast<int>(fault));
    EXPECT_EQ(monitor.reliable(), reliability != GyroReliability::kRejected);
  }
};

TEST(GyroMonitor, IsUnprovenBeforeAnythingTurns) {
  EXPECT_EQ(GyroMonitor(EkfConfig{}).verdict(0.0).reliability, GyroReliability::kNone);
  Drive drive;
  drive.go(20.0, 0.0);
  drive.expect(GyroReliability::kUnproven, GyroFault::kNone);
  EXPECT_TRUE(drive.newest.rate_known);
}

TEST(GyroMonitor, NeverRejectsASoundGyro) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    Drive drive(seed);
    drive.gyro.reads = [](double rate) { return 1.01 * rate + 0.01; };
    for (int i = 0; i < 20; ++i) {
      drive.go(10.0);
      ASSERT_TRUE(drive.monitor.reliable()) << seed;
    }
    drive.expect(GyroReliability::kReliable, GyroFault::kNone);
    EXPECT_EQ(drive.distrusted + drive.withdrawn, 0) << seed;
  }
}

TEST(GyroMonitor, WheelsThatSlipAreNoReasonToRejectTheGyro) {
  for (const double spin : {0.3, -0.6, 2.0}) {
    Drive drive;
    drive.go(10.0);
    for (int i = 0; i < 10; ++i) {
      drive.wheels.spin.z() = i % 2 == 0 ? spin : 0.0;
      drive.go(4.0);
      ASSERT_TRUE(drive.monitor.reliable()) << spin;
    }
    drive.expect(GyroReliability::kReliable, GyroFault::kNone);
  }
}

TEST(GyroMonitor, ScansThatContradictGyroAndWheelsAreNoReasonToRejectIt) {
  Drive drive;
  drive.matches.drift = 0.3;
  drive.go(60.0);
  drive.expect(GyroReliability::kReliable, GyroFault::kNone);
  EXPECT_EQ(drive.distrusted + drive.withdrawn, 0);
}

TEST(GyroMonitor, AGyroThatLagsIsNotTakenForAWrongOne) {
  Drive drive;
  double last = 0.0, before = 0.0;
  drive.gyro.reads = [&](double rate) { return std::exchange(before, std::exchange(last, rate)); };  // by 0.04 s
  drive.time = 4.0;  // shortly before it turns back
  drive.go(1.5, 8.0);
  EXPECT_EQ(drive.distrusted, 0);
}

TEST(GyroMonitor, WheelsThatAreWrongFromTheBeginningAreFoundOutByScans) {
  for (const double scale : {-1.0, 0.0, 2.0}) {
    Drive drive;
    drive.wheels.turn_scale = scale;
    drive.go(20.0);
    drive.expect(GyroReliability::kReliable, GyroFault::kNone);
    EXPECT_EQ(drive.withdrawn, 0) << "scans never contradict it";
  }
}

TEST(GyroMonitor, FindsDegreesForRadiansBeforeTheFirstScanThatTurns) {
  Drive drive;
  drive.gyro.fault.degrees = true;
  drive.go(0.6);
  EXPECT_EQ(drive.distrusted, 1) << "by the wheels";
  EXPECT_FALSE(drive.newest.rate_known);
  drive.go(20.0);
  drive.expect(GyroReliability::kRejected, GyroFault::kDegrees);
  EXPECT_NEAR(drive.verdict().value, kDegrees, 0.05 * kDegrees);
  EXPECT_EQ(drive.used_again, 0);
}

TEST(GyroMonitor, FindsAnAxisThatPointsDown) {
  Drive drive;
  drive.gyro.fault.down = true;
  drive.go(20.0);
  drive.expect(GyroReliability::kRejected, GyroFault::kReversed);
  EXPECT_EQ(drive.used_again, 0);
}

TEST(GyroMonitor, FindsAWrongScale) {
  Drive drive;
  drive.gyro.reads = [](double rate) { return 0.5 * rate; };
  drive.go(30.0);
  drive.expect(GyroReliability::kRejected, GyroFault::kScale);
  EXPECT_NEAR(drive.verdict().value, 0.5, 0.05);
}

TEST(GyroMonitor, FindsAGyroThatMeasuresNoTurns) {
  Drive drive;
  drive.gyro.reads = [&drive](double rate) { return rate + 0.8 * std::sin(5.0 * drive.time); };
  drive.go(60.0);
  drive.expect(GyroReliability::kRejected, GyroFault::kUnrelated);
}

TEST(GyroMonitor, WithoutWheelsTheScansDecideAlone) {
  for (const double scale : {kDegrees, -1.5, 4.0}) {
    Drive drive;
    drive.wheels.there = false;
    drive.gyro.reads = [scale](double rate) { return scale * rate; };
    drive.go(30.0);
    EXPECT_FALSE(drive.monitor.reliable()) << scale;
  }
  Drive sound;
  sound.wheels.there = false;
  sound.go(60.0);
  sound.expect(GyroReliability::kReliable, GyroFault::kNone);
}

TEST(GyroMonitor, LearnsAnOffsetAndUsesTheGyroAgain) {
  for (const double offset : {0.2, -0.45}) {
    Drive drive;
    drive.gyro.fault.offset = offset;
    drive.go(20.0);
    drive.expect(GyroReliability::kReliable, GyroFault::kOffset);
    EXPECT_NEAR(drive.bias, offset, kBiasError);
    EXPECT_EQ(drive.used_again, 1);
    EXPECT_EQ(drive.verdict().value, drive.bias);
    EXPECT_TRUE(drive.newest.rate_known);
  }
}

TEST(GyroMonitor, AnOffsetBeyondAnyBiasIsAFault) {
  Drive drive;
  drive.gyro.fault.offset = 1.0;
  drive.go(30.0);
  drive.expect(GyroReliability::kRejected, GyroFault::kOffset);
  EXPECT_NEAR(drive.verdict().value, 1.0, 0.05);
}

TEST(GyroMonitor, FindsTheEndOfTheRangeAndUsesWhatIsBelow) {
  for (const double range : {0.3, 0.5}) {
    Drive drive;
    drive.gyro.fault.clip = range;
    drive.go(20.0);
    EXPECT_TRUE(drive.monitor.reliable()) << range;
    EXPECT_EQ(drive.verdict().fault, GyroFault::kClipped);
    EXPECT_EQ(drive.verdict().value, range);
    drive.time = 0.0;
    drive.go(2.0);
    EXPECT_FALSE(drive.newest.rate_known) << "at full turn";
    drive.go(20.0, 0.2);
    EXPECT_TRUE(drive.newest.rate_known);
    drive.gyro.fault = {};
    drive.go(10.0);
    drive.expect(GyroReliability::kReliable, GyroFault::kNone);
  }
}

TEST(GyroMonitor, StepsOfADegreeAreNoFault) {
  Drive drive;
  drive.gyro.fault.step = 1.0 / kDegrees;
  for (int i = 0; i < 20; ++i) {
    drive.go(5.0);
    ASSERT_TRUE(drive.monitor.reliable());
  }
  drive.expect(GyroReliability::kReliable, GyroFault::kNone);
}

TEST(GyroMonitor, AGyroThatIsRightAgainIsUsedAgain) {
  Drive drive;
  drive.go(20.0);
  drive.gyro.reads = [](double) { return 0.0; };  // stuck
  drive.go(20.0);
  EXPECT_FALSE(drive.monitor.reliable());
  EXPECT_EQ(drive.withdrawn, 1);
  EXPECT_EQ(drive.monitor.rejections(), 1);
  drive.gyro.reads = {};
  drive.gyro.fault.offset = 0.03;
  drive.go(30.0);
  drive.expect(GyroReliability::kReliable, GyroFault::kNone);
  EXPECT_EQ(drive.used_again, 1);
  EXPECT_NEAR(drive.bias, 0.03, kBiasError);
}

TEST(GyroMonitor, ARestIsNoProofThatAReversedGyroIsRight) {
  Drive drive;
  drive.gyro.fault.down = true;
  drive.go(20.0);
  drive.go(60.0, 0.0);
  drive.expect(GyroReliability::kRejected, GyroFault::kReversed);
}

TEST(GyroMonitor, ReadingsThatAreNoNumberAreNotEvaluated) {
  Drive drive;
  drive.go(20.0);
  for (const double none : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    drive.monitor.add(ImuSample{.stamp = drive.newest.stamp, .gyro = {0.0, 0.0, none}});
    drive.monitor.add(WheelSample{.stamp = drive.newest.stamp, .T_wheels_base = {0.0, 0.0, none}}, 0.0);
  }
  drive.go(20.0);
  drive.expect(GyroReliability::kReliable, GyroFault::kNone);
}

TEST(GyroMonitor, DoesNotAllocate) {
  Drive drive;
  drive.gyro.fault.down = true;
  EXPECT_EQ(test::allocationsDuring([&] { drive.go(20.0); }), 0U);
}

TEST(GyroMonitor, ABiasThatIsKnownIsTakenOffBeforeItIsComparedWithTheWheels) {
  for (const double offset : {0.25, -0.25}) {
    Drive known, unknown;
    for (Drive* drive : {&known, &unknown}) drive->gyro.fault.offset = offset;
    known.bias = offset;
    for (Drive* drive : {&known, &unknown}) drive->go(4.0, std::copysign(0.8, offset));
    EXPECT_EQ(known.distrusted, 0) << offset;
    EXPECT_GT(unknown.distrusted, 0) << offset;
  }
}

}  // namespace
}  // namespace slam::gyro_monitor_test
