// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <utility>

#include "support/simulated/robot.hpp"

namespace slam::wheel_monitor_test {
namespace {

WheelReliability reliability(WheelMonitor monitor) {
  monitor.add({});
  return monitor.reliability();
}
bool consistent(const WheelMonitor& monitor) { return reliability(monitor) == WheelReliability::kConsistent; }

/// A winding way, which wheels and matched scans both measure, each with its own errors.
class Drive : public test::SimulatedRobot {
 public:
  explicit Drive(unsigned seed) : SimulatedRobot(test::Room{}, {}, seed) {
    lidar.every = 1;
    matches.sigma = {0.005, 0.005, 0.002};
    wheels.pose = {3.0, -1.0, 2.0};
  }

  /// @param noise of the wheels [m per sqrt(m), rad per sqrt(m)]  @param scale what they measure of a way of 1
  /// @param step [m] from scan to scan @param turn_share noise of the turn beside that of the way
  void go(double metres, double noise, double scale = 1.0, double step = 0.06, double turn_share = 0.3) {
    wheels.scale = scale;
    wheels.sigma = noise * std::sqrt(step);
    wheels.turn_sigma = turn_share * wheels.sigma;
    const double speed = step / toSeconds(kStep);
    for (double way = 0.0; way < metres; way += step) this->step({speed, 0.0, 0.5 * speed * std::sin(way)}, *this);
  }
  void stand(int scans) {
    wheels.sigma = wheels.turn_sigma = 0.0;
    for (int i = 0; i < scans; ++i) step({0, 0, 0}, *this);
  }
  void add(const PoseMeasurement& match) { monitor.compare(wheels.pose, match.T_map_base, true); }

  WheelMonitor monitor{EkfConfig{}};
};

TEST(WheelMonitor, AcceptsWheelsAsGoodAsTheFilterTakesThemFor) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    Drive drive(seed);
    drive.go(300.0, 0.10);
    EXPECT_TRUE(drive.monitor.reliable()) << seed;
    drive.go(100.0, 0.10, 1.3);  // a wrong radius
    EXPECT_TRUE(drive.monitor.reliable()) << seed;
    EXPECT_EQ(drive.monitor.rejections(), 0) << seed;
  }
}

TEST(WheelMonitor, WithdrawsFromWheelsThatAreWorseThanNoneAndComesBack) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Drive drive(seed);
    drive.go(30.0, 0.05);
    drive.go(8.0, 0.05, -1.0);  // they report the opposite
    EXPECT_FALSE(drive.monitor.reliable()) << seed;
    drive.go(8.0, 0.6);
    EXPECT_FALSE(drive.monitor.reliable()) << seed;
    drive.go(20.0, 0.05);
    EXPECT_TRUE(drive.monitor.reliable()) << seed;
    EXPECT_EQ(drive.monitor.rejections(), 1) << seed;
  }
}

TEST(WheelMonitor, DoesNotDependOnHowOftenScansCome) {
  for (const double step : {0.01, 0.03, 0.06, 0.2}) {
    Drive good(1), bad(1);
    good.go(100.0, 0.10, 1.0, step);
    bad.go(100.0, 0.60, 1.0, step);
    EXPECT_TRUE(good.monitor.reliable()) << step;
    EXPECT_FALSE(bad.monitor.reliable()) << step;
  }
}

TEST(WheelMonitor, RejectedWheelsAreUsedWhileNoScanShowsTheMotion) {
  Drive drive(1);
  drive.go(30.0, 0.01, -1.0);
  ASSERT_EQ(reliability(drive.monitor), WheelReliability::kRejected);
  ASSERT_FALSE(drive.monitor.add({}));
  const auto corrected = drive.monitor.add({}, true);
  ASSERT_TRUE(corrected);
  EXPECT_TRUE(corrected->restarted) << "what they reported before is not made up for";
  EXPECT_FALSE(drive.monitor.add({}, true)->restarted);
  EXPECT_EQ(reliability(drive.monitor), WheelReliability::kRejected) << "the verdict stays";
  EXPECT_FALSE(drive.monitor.add({})) << "a scan matches again";
}

TEST(WheelMonitor, OneSlipIsForgiven) {
  Drive drive(1);
  drive.go(20.0, 0.05);
  drive.go(0.12, 0.0, 20.0);  // spins on the spot
  EXPECT_TRUE(drive.monitor.reliable());
}

TEST(WheelMonitor, ManySlipsApartAreForgiven) {
  Drive drive(1);
  for (int i = 0; i < 30; ++i) {
    drive.go(2.0, 0.05);
    for (const double radians : {0.07, 0.14, 0.08}) {  // over three scans
      drive.wheels.leap({0.0, 0.0, radians});          // one wheel spins
      drive.go(0.12, 0.05);
    }
    EXPECT_TRUE(drive.monitor.reliable()) << i;
  }
}

TEST(WheelMonitor, TurnsThatTheWheelsMakeUpAreNoExcuseForThemselves) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Drive drive(seed);
    drive.go(30.0, 0.10, 1.0, 0.06, 5.0);
    EXPECT_GT(drive.monitor.turnFactor(), 3.0) << seed;
    EXPECT_FALSE(drive.monitor.reliable()) << seed;
  }
}

TEST(WheelMonitor, MeasuresHowMuchWorseTheWheelsAreThanTheModel) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Drive drive(seed);
    drive.go(60.0, 0.05);
    EXPECT_EQ(drive.monitor.distanceFactor(), 1.0) << "no better than the model";
    EXPECT_EQ(drive.monitor.turnFactor(), 1.0);
    EXPECT_TRUE(drive.monitor.reliable());
    drive.go(60.0, 0.16, 1.0, 0.06, 0.1);  // 2.6 times the variance
    EXPECT_GT(drive.monitor.distanceFactor(), 1.4) << seed;
    EXPECT_LT(drive.monitor.distanceFactor(), 3.6) << seed;
  }
}

TEST(WheelMonitor, LearnsNothingFromStandingStill) {
  Drive drive(1);
  drive.go(8.0, 0.05, -1.0);
  ASSERT_FALSE(drive.monitor.reliable());
  drive.stand(10000);
  EXPECT_FALSE(drive.monitor.reliable());
}

TEST(WheelMonitor, AnInterruptedStretchIsNotEvaluated) {
  WheelMonitor monitor{EkfConfig{}};
  for (int i = 0; i < 200; ++i) {
    monitor.compare({1.0 * i, 0.0, 0.0}, {0.1 * i, 0.0, 0.0}, true);
    monitor.interrupt();
  }
  EXPECT_TRUE(monitor.reliable());
}

/// Stretches straight ahead of which the wheels report so much more than the scans, exactly.
WheelMonitor after(int intervals, const Pose2& scans, const Pose2& wheels, bool turn_known,
                   const WheelMonitorConfig& config = {}) {
  WheelMonitor monitor(EkfConfig{}, config);
  Pose2 map, odom{3.0, -1.0, 2.0};
  monitor.compare(odom, map, turn_known);
  for (int i = 0; i < intervals; ++i) monitor.compare(odom = odom * wheels, map = map * scans, turn_known);
  return monitor;
}

TEST(WheelMonitor, OneStretchCountsByItsErrorAndTheMemory) {
  const EkfConfig noise;
  for (const double memory : {50.0, 20.0}) {
    WheelMonitorConfig config;
    config.memory = memory;
    const WheelMonitor far = after(1, {0.06, 0, 0}, {0.16, 0, 0}, true, config);
    const double variance = noise.wheelTranslationVariance(0.16) + 0.01 * 0.01;
    EXPECT_NEAR(far.distanceFactor(), 1.0 + (0.1 * 0.1 / variance - 1.0) / memory, 1e-9);
    EXPECT_EQ(far.turnFactor(), 1.0);
    const WheelMonitor turned = after(1, {0.06, 0, 0.02}, {0.06, 0, 0.12}, true, config);
    const double turn_variance = noise.wheelRotationVariance(0.06, 0.02) + 0.005 * 0.005;
    EXPECT_NEAR(turned.turnFactor(), 1.0 + (0.1 * 0.1 / turn_variance - 1.0) / memory, 1e-9);
    const WheelMonitor jump = after(1, {0.06, 0, 0}, {5.0, 0, 2.0}, true, config);
    EXPECT_NEAR(jump.turnFactor(), 1.0 + 9.0 / memory, 1e-9) << "one interval counts for no more than ten";
    EXPECT_EQ(after(1, {0.06, 0, 0.02}, {0.06, 0, 0.12}, false, config).turnFactor(), 1.0)
        << "a gyro measures the turn";
  }
}

TEST(WheelMonitor, AStretchIsEvaluatedFromItsLengthOrItsTurnOn) {
  const auto evaluated = [](const Pose2& scans, const Pose2& wheels) {
    const WheelMonitor monitor = after(1, scans, wheels, true);
    return std::max(monitor.distanceFactor(), monitor.turnFactor()) > 1.0;
  };
  EXPECT_FALSE(evaluated({0, 0, 0}, {0.049, 0, 0}));
  EXPECT_TRUE(evaluated({0, 0, 0}, {0.051, 0, 0.04}));
  EXPECT_FALSE(evaluated({0, 0, 0.0}, {0, 0, 0.049}));
  EXPECT_TRUE(evaluated({0, 0, 0.0}, {0, 0, 0.051}));
  EXPECT_TRUE(evaluated({0, 0, 0.3}, {0, 0, 0.0}));
}

TEST(WheelMonitor, IsWithdrawnGivenBackAndGuidesAtItsLimits) {
  // Errors whose mean comes as near to a limit as one likes: each interval counts the same.
  const auto settled = [](double factor) {
    const EkfConfig noise;
    const double variance = noise.wheelRotationVariance(0.06, 0.0) + 0.005 * 0.005;
    return after(2000, {0.06, 0, 0}, {0.06, 0, std::sqrt(factor * variance)}, true);
  };
  EXPECT_TRUE(settled(2.9).reliable());
  EXPECT_FALSE(settled(3.1).reliable());
  EXPECT_EQ(settled(2.9).rejections(), 0);
  EXPECT_EQ(settled(3.1).rejections(), 1);
  EXPECT_TRUE(consistent(settled(1.05)));
  EXPECT_FALSE(consistent(settled(1.15)));
  for (const auto& [factor, back] : {std::pair(1.6, false), std::pair(1.4, true)}) {
    WheelMonitor monitor(EkfConfig{});
    const EkfConfig noise;
    const double variance = noise.wheelRotationVariance(0.06, 0.0) + 0.005 * 0.005;
    Pose2 map, odom;
    for (const double f : {5.0, factor}) {
      for (int i = 0; i < 1000; ++i) {
        monitor.compare(odom = odom * Pose2{0.06, 0, std::sqrt(f * variance)}, map = map * Pose2{0.06, 0, 0}, true);
      }
    }
    EXPECT_EQ(monitor.reliable(), back) << factor;
    EXPECT_EQ(monitor.rejections(), 1);
  }
}

TEST(WheelMonitor, AreConsistentWithAFirstScanThatIsPulledBack) {
  EXPECT_TRUE(consistent(after(1, {0.055, 0, 0}, {0.0, 0, 0}, false)));
  EXPECT_FALSE(consistent(after(3, {0.055, 0, 0}, {0.0, 0, 0}, false)));
}

TEST(WheelMonitor, WheelsThatAreOffTheWallsHeadingHaveSlipped) {
  const WheelMonitor monitor(EkfConfig{});
  EXPECT_FALSE(monitor.slipped(0.029)) << "the wheels' own error";
  EXPECT_TRUE(monitor.slipped(0.031));
  EXPECT_TRUE(monitor.slipped(-0.031));
}

TEST(WheelMonitor, HandsOnWhatItReceivesUntilTheWheelsAreRejectedAndBeginsAnewBehindThat) {
  WheelMonitor monitor(EkfConfig{});
  EXPECT_EQ(monitor.reliability(), WheelReliability::kNone);
  const auto add = [&](double x) { return monitor.add({Timestamp{}, {x, 0.0, 0.0}}); };
  EXPECT_TRUE(add(0.0));
  EXPECT_EQ(monitor.reliability(), WheelReliability::kConsistent);
  Pose2 odom, map;
  const auto go = [&](double turned, int intervals) {
    for (int i = 0; i < intervals; ++i)
      monitor.compare(odom = odom * Pose2{0.06, 0.0, turned}, map = map * Pose2{0.06, 0.0, 0.0}, true);
  };
  go(0.3, 100);
  EXPECT_EQ(monitor.reliability(), WheelReliability::kRejected);
  EXPECT_FALSE(add(1.0));
  EXPECT_FALSE(add(2.0));
  go(0.0, 500);
  ASSERT_EQ(monitor.reliability(), WheelReliability::kConsistent);
  auto sample = add(3.0);
  ASSERT_TRUE(sample);
  EXPECT_TRUE(sample->restarted) << "what they reported meanwhile is not made up for";
  sample = add(3.5);
  EXPECT_FALSE(sample->restarted);
}

TEST(WheelMonitor, EvaluatesByScansThatShowedTheWholePoseOnly) {
  const auto rejected = [](bool complete, bool has_samples) {
    WheelMonitor monitor(EkfConfig{});
    if (has_samples) monitor.add({});
    const EkfConfig config;
    Pose2 odom, map;
    for (int i = 0; i < 200; ++i) {
      Ekf filter(config, Timestamp{}, odom = odom * Pose2{0.06, 0.0, 0.3});
      monitor.compare(filter, map = map * Pose2{0.06, 0.0, 0.0}, complete);
    }
    return !monitor.reliable();
  };
  EXPECT_TRUE(rejected(true, true));
  EXPECT_FALSE(rejected(false, true));
  EXPECT_FALSE(rejected(true, false)) << "there are no wheels";
}

}  // namespace
}  // namespace slam::wheel_monitor_test
