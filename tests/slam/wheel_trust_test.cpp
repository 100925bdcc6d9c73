// SPDX-License-Identifier: BSD-3-Clause
#include "slam/wheel_trust.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace slam {
namespace {

/// Drives a winding way, which wheels and matched scans both tell, each with its own errors.
class Drive {
 public:
  explicit Drive(unsigned seed, const WheelTrustConfig& config = {}) : trust(EkfConfig{}, config), random_(seed) {}

  /// @param noise of the wheels [m per sqrt(m), rad per sqrt(m)]  @param scale what they tell of a way of 1
  /// @param step [m] from scan to scan @param turn_share noise of the turn beside that of the way
  void go(double metres, double noise, double scale = 1.0, double step = 0.06, double turn_share = 0.3) {
    for (double way = 0.0; way < metres; way += step) {
      const Pose2 motion{step, 0.0, 0.5 * step * std::sin(way)};
      T_map_base_ = T_map_base_ * motion;
      const double spread = noise * std::sqrt(step);
      T_odom_base_ = T_odom_base_ * Pose2{scale * motion.x + spread * normal_(random_), 0.0,
                                          motion.theta + turn_share * spread * normal_(random_)};
      trust.add(T_odom_base_, seen(), true);
    }
  }
  /// One wheel spins: a turn that was none.
  void slip(double radians) { T_odom_base_ = T_odom_base_ * Pose2{0.0, 0.0, radians}; }
  void stand(int scans) {
    for (int i = 0; i < scans; ++i) trust.add(T_odom_base_, seen(), true);
  }

  WheelTrust trust;

 private:
  Pose2 seen() {
    return T_map_base_ * Pose2{0.005 * normal_(random_), 0.005 * normal_(random_), 0.002 * normal_(random_)};
  }

  Pose2 T_odom_base_{3.0, -1.0, 2.0}, T_map_base_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

TEST(WheelTrust, BelievesWheelsAsGoodAsTheFilterTakesThemFor) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    Drive drive(seed);
    drive.go(300.0, 0.10);
    EXPECT_TRUE(drive.trust.believed()) << seed;
    drive.go(100.0, 0.10, 1.3);  // a wrong radius
    EXPECT_TRUE(drive.trust.believed()) << seed;
    EXPECT_EQ(drive.trust.withdrawn(), 0) << seed;
  }
}

TEST(WheelTrust, WithdrawsFromWheelsThatAreWorseThanNoneAndComesBack) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Drive drive(seed);
    drive.go(30.0, 0.05);
    drive.go(8.0, 0.05, -1.0);  // they tell the opposite
    EXPECT_FALSE(drive.trust.believed()) << seed;
    drive.go(8.0, 0.6);
    EXPECT_FALSE(drive.trust.believed()) << seed;
    drive.go(20.0, 0.05);
    EXPECT_TRUE(drive.trust.believed()) << seed;
    EXPECT_EQ(drive.trust.withdrawn(), 1) << seed;
  }
}

TEST(WheelTrust, DoesNotDependOnHowOftenScansCome) {
  for (const double step : {0.01, 0.03, 0.06, 0.2}) {
    Drive good(1), bad(1);
    good.go(100.0, 0.10, 1.0, step);
    bad.go(100.0, 0.60, 1.0, step);
    EXPECT_TRUE(good.trust.believed()) << step;
    EXPECT_FALSE(bad.trust.believed()) << step;
  }
}

TEST(WheelTrust, OneSlipIsForgiven) {
  Drive drive(1);
  drive.go(20.0, 0.05);
  drive.go(0.12, 0.0, 20.0);  // spins on the spot
  EXPECT_TRUE(drive.trust.believed());
}

TEST(WheelTrust, ManySlipsApartAreForgiven) {
  Drive drive(1);
  for (int i = 0; i < 30; ++i) {
    drive.go(2.0, 0.05);
    for (const double radians : {0.07, 0.14, 0.08}) {  // over three scans
      drive.slip(radians);
      drive.go(0.12, 0.05);
    }
    EXPECT_TRUE(drive.trust.believed()) << i;
  }
}

TEST(WheelTrust, TurnsThatTheWheelsMakeUpAreNoExcuseForThemselves) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Drive drive(seed);
    drive.go(30.0, 0.10, 1.0, 0.06, 5.0);
    EXPECT_GT(drive.trust.turnFactor(), 3.0) << seed;
    EXPECT_FALSE(drive.trust.believed()) << seed;
  }
}

TEST(WheelTrust, TellsHowMuchWorseTheWheelsAreThanTheModel) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Drive drive(seed);
    drive.go(60.0, 0.05);
    EXPECT_EQ(drive.trust.distanceFactor(), 1.0) << "no better than the model";
    EXPECT_EQ(drive.trust.turnFactor(), 1.0);
    EXPECT_TRUE(drive.trust.guides());
    drive.go(60.0, 0.16, 1.0, 0.06, 0.1);  // 2.6 times the variance
    EXPECT_GT(drive.trust.distanceFactor(), 1.4) << seed;
    EXPECT_LT(drive.trust.distanceFactor(), 3.6) << seed;
  }
}

TEST(WheelTrust, NoisyWheelsStopToGuideBeforeTheyAreNotHeard) {
  Drive drive(1);
  while (drive.trust.guides()) drive.go(0.06, 0.16);
  EXPECT_TRUE(drive.trust.believed());
  drive.go(30.0, 0.4);
  EXPECT_FALSE(drive.trust.believed());
  EXPECT_FALSE(drive.trust.guides());
}

TEST(WheelTrust, LearnsNothingFromStandingStill) {
  Drive drive(1);
  drive.go(8.0, 0.05, -1.0);
  ASSERT_FALSE(drive.trust.believed());
  drive.stand(10000);
  EXPECT_FALSE(drive.trust.believed());
}

TEST(WheelTrust, AnInterruptedStretchIsNotJudged) {
  WheelTrust trust{EkfConfig{}};
  for (int i = 0; i < 200; ++i) {
    trust.add({1.0 * i, 0.0, 0.0}, {0.1 * i, 0.0, 0.0}, true);
    trust.interrupt();
  }
  EXPECT_TRUE(trust.believed());
}

}  // namespace
}  // namespace slam
