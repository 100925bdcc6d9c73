// SPDX-License-Identifier: BSD-3-Clause
// Each of the filter's limits from both sides, and what each of its settings does.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>

#include "estimation/ekf.hpp"

namespace slam::ekf_limits_test {
namespace {

using std::chrono::milliseconds;

constexpr Timestamp kBegin{std::chrono::seconds(1000)};
const EkfConfig kConfig;

double variance(const Ekf& ekf, Ekf::Index i) { return ekf.covariance()(i, i); }

PoseMeasurement measured(const Pose2& pose, double sigma = 0.01) {
  PoseMeasurement measurement{.stamp = {}, .T_map_base = pose};
  measurement.covariance = square(sigma) * Eigen::Matrix3d::Identity();
  return measurement;
}

/// A filter that stands, for wheels without a gyro.
Ekf standing(const EkfConfig& config = kConfig) {
  Ekf ekf(config, kBegin);
  for (int i = 0; i < 100; ++i) {
    ekf.updateWheels({}, true, milliseconds(20), std::nullopt);
    ekf.predict(ekf.stamp() + milliseconds(20));
  }
  return ekf;
}

TEST(EkfLimits, ASuddenSpeedIsAcceptedUpToWhatARobotCanDrive) {
  static const EkfConfig config = [] {
    EkfConfig holonomic;
    holonomic.holonomic = true;
    holonomic.max_speed = 3.0;
    holonomic.max_turn_rate = 7.0;
    return holonomic;
  }();
  struct Case {
    Twist2 twist;
    bool possible;
  };
  for (const Case& c : {Case{{2.9, 0, 0}, true}, Case{{3.1, 0, 0}, false}, Case{{-3.1, 0, 0}, false},
                        Case{{0, 2.9, 0}, true}, Case{{0, -3.1, 0}, false}, Case{{2.2, 2.2, 0}, false},
                        Case{{0.5, 0, 6.9}, true}, Case{{0.5, 0, 7.1}, false}, Case{{0.5, 0, -7.1}, false}}) {
    Ekf ekf = standing(config), held = ekf;
    ekf.updateWheels(c.twist, true, milliseconds(2), std::nullopt);
    held.holdTwist(c.twist, true);
    for (const Ekf* filter : {&ekf, &held}) {
      const Twist2 twist = filter->twist();
      const double believed = std::hypot(twist.vx, twist.vy), told = std::hypot(c.twist.vx, c.twist.vy);
      EXPECT_EQ(believed > 0.5 * told, c.possible) << c.twist.vx << " " << c.twist.vy << " " << c.twist.omega;
      if (c.twist.omega != 0.0) {
        EXPECT_EQ(std::abs(twist.omega) > 5.0, c.possible);
      }
    }
  }
}

TEST(EkfLimits, WheelsAndGyroThatDifferByMoreThanTheSlipAngleSlip) {
  const auto slips = [](double wheels, double gyro, double seconds) {
    Ekf ekf = standing();
    ekf.updateWheels({0.3, 0, wheels}, true, fromSeconds(seconds), gyro);
    return ekf.slip();
  };
  EXPECT_FALSE(slips(0.34, 0.0, 0.1)) << "0.034 rad";
  EXPECT_TRUE(slips(0.36, 0.0, 0.1)) << "0.036 rad";
  EXPECT_TRUE(slips(-0.36, 0.0, 0.1));
  EXPECT_FALSE(slips(0.36, 0.0, 0.09));
  EXPECT_FALSE(slips(1.44, 1.0, 0.1)) << "a tenth of the angle turned is forgiven, too";
  EXPECT_TRUE(slips(1.46, 1.0, 0.1));
  EXPECT_TRUE(slips(-0.54, -1.0, 0.1));
}

TEST(EkfLimits, SlipIsForgottenOverItsWindow) {
  for (const auto& [second, slip] : {std::pair(0.20, false), std::pair(0.23, true)}) {
    Ekf ekf = standing();
    ekf.updateWheels({0.3, 0, 0.2}, true, milliseconds(100), 0.0);
    ASSERT_FALSE(ekf.slip());
    ekf.updateWheels({0.3, 0, second}, true, milliseconds(100), 0.0);  // 0.035 - 0.020 exp(-0.1 / 0.25) is left
    EXPECT_EQ(ekf.slip(), slip) << second;
  }
}

TEST(EkfLimits, SlipNeedsAGyroAndATurnOfTheWheels) {
  Ekf ekf = standing();
  ekf.updateWheels({0.3, 0, 2.0}, true, milliseconds(100), std::nullopt);
  EXPECT_FALSE(ekf.slip());
  ekf.updateWheels({0.3, 0, 2.0}, false, milliseconds(100), 0.0);
  EXPECT_FALSE(ekf.slip());
  ekf.updateWheels({0.3, 0, 2.0}, true, milliseconds(100), 0.0);
  ASSERT_TRUE(ekf.slip());
  const Ekf slipping = ekf;
  ekf.holdTwist({0.7, 0, 0}, true);
  EXPECT_EQ(ekf.state(), slipping.state()) << "no speed of slipping wheels is held";
  ekf.updateWheels({0.3, 0, 2.0}, true, milliseconds(100), std::nullopt);
  EXPECT_FALSE(ekf.slip());
}

TEST(EkfLimits, SlippingWheelsAreWorthTheirOwnSigmaAndGiveNoTurn) {
  Ekf ekf = standing();
  const double prior = variance(ekf, Ekf::kSpeed) + square(kConfig.acceleration_noise) * 0.1;
  const double turn_rate = ekf.twist().omega;
  ekf.updateWheels({0.2, 0, 2.0}, true, milliseconds(100), 0.0);
  ASSERT_TRUE(ekf.slip());
  EXPECT_NEAR(1.0 / variance(ekf, Ekf::kSpeed), 1.0 / prior + 1.0 / square(kConfig.slip_speed_sigma), 1e-3);
  EXPECT_EQ(ekf.twist().omega, turn_rate);
}

TEST(EkfLimits, TheBiasIsTakenOffTheGyroBeforeItIsComparedWithTheWheels) {
  static const EkfConfig config = [] {
    EkfConfig biased;
    biased.initial_gyro_bias = 1.0;
    return biased;
  }();
  Ekf ekf(config, kBegin);
  ekf.updateWheels({0.3, 0, 0.0}, true, milliseconds(100), 1.0);
  EXPECT_FALSE(ekf.slip());
  ekf.updateWheels({0.3, 0, 0.0}, true, milliseconds(100), 0.0);
  EXPECT_TRUE(ekf.slip());
}

TEST(EkfLimits, AGyroIsSilentAfterItsTimeout) {
  Ekf ekf = standing();
  EXPECT_FALSE(ekf.gyroActive());
  ekf.updateGyro(0.0);
  ekf.predict(ekf.stamp() + milliseconds(199));
  EXPECT_TRUE(ekf.gyroActive());
  const double omega = ekf.twist().omega;
  Ekf with = ekf;
  with.updateWheels({0.3, 0, 0.4}, true, milliseconds(20), std::nullopt);
  EXPECT_EQ(with.twist().omega, omega) << "the wheels tell no turn";
  with.holdTwist({0.3, 0, 0.4}, true);
  EXPECT_EQ(with.twist().omega, omega);
  ekf.predict(ekf.stamp() + milliseconds(2));
  EXPECT_FALSE(ekf.gyroActive());
  ekf.updateWheels({0.3, 0, 0.4}, true, milliseconds(20), std::nullopt);
  EXPECT_GT(ekf.twist().omega, 0.3);
}

TEST(EkfLimits, WheelsAreSilentTwoIntervalsAfterTheyWereDue) {
  struct Case {
    int interval, silent_after;  // [ms] beyond the interval
  };
  for (const Case& c : {Case{20, 100}, Case{49, 100}, Case{200, 400}, Case{600, 1000}, Case{3000, 1000}}) {
    Ekf ekf(kConfig, kBegin);
    ekf.updateWheels({0.3, 0, 0}, true, milliseconds(c.interval), std::nullopt);
    const Timestamp until = kBegin + milliseconds(c.interval + c.silent_after);
    ekf.predict(until);
    EXPECT_FALSE(ekf.wheelsSilent()) << c.interval;
    ekf.predict(until + milliseconds(1));
    EXPECT_TRUE(ekf.wheelsSilent()) << c.interval;
  }
}

TEST(EkfLimits, SilentWheelsAreNoStandstill) {
  Ekf ekf = standing();
  ekf.predict(ekf.stamp() + milliseconds(100));
  EXPECT_TRUE(ekf.standstill());
  ekf.predict(ekf.stamp() + milliseconds(1));
  EXPECT_FALSE(ekf.standstill());
}

TEST(EkfLimits, TheThirdMatchInARowOutsideTheGateIsAccepted) {
  Ekf ekf = standing();
  ekf.setPose({}, {0.01, 0.01, 0.01});
  const PoseMeasurement far = measured({0.5, 0, 0}), here = measured({});
  EXPECT_EQ(ekf.updatePose(far), UpdateResult::kRejected);
  EXPECT_EQ(ekf.updatePose(far), UpdateResult::kRejected);
  Ekf interrupted = ekf, set = ekf;
  EXPECT_EQ(ekf.updatePose(far), UpdateResult::kFused);
  EXPECT_NEAR(ekf.pose().x, 0.5, 0.05);
  EXPECT_EQ(interrupted.updatePose(here), UpdateResult::kFused);
  EXPECT_EQ(interrupted.updatePose(far), UpdateResult::kRejected) << "it counts from anew";
  set.setPose({}, {0.01, 0.01, 0.01});
  EXPECT_EQ(set.updatePose(far), UpdateResult::kRejected) << "it counts from anew";
}

TEST(EkfLimits, NoMatchIsAcceptedFartherThanARobotIsCarried) {
  for (const auto& [metres, believed] : {std::pair(990.0, true), std::pair(1010.0, false)}) {
    Ekf ekf = standing();
    PoseMeasurement match = measured({0.0, metres, 0.0});
    match.bypass_gate = true;
    EXPECT_EQ(ekf.updatePose(match) == UpdateResult::kFused, believed) << metres;
  }
}

TEST(EkfLimits, TheGateOfEachUpdateIsThatOfItsDegreesOfFreedom) {
  // The chi-square quantiles of 0.9999 are 15.1, 18.4 and 21.1; the approximation lies up to 7 % above.
  const std::array<double, 3> limits{15.1, 18.4, 21.1};
  for (int observable = 1; observable <= 3; ++observable) {
    for (const double share : {0.98, 1.09}) {
      Ekf ekf(kConfig, kBegin);
      ekf.setPose({}, {0.3, 0.3, 0.3});
      const double S = square(0.3) + square(0.4);
      const double each = std::sqrt(share * limits[static_cast<std::size_t>(observable - 1)] * S / observable);
      PoseMeasurement match = measured({each, each, each}, 0.4);
      match.observable = observable;
      EXPECT_EQ(ekf.updatePose(match), share < 1.0 ? UpdateResult::kFused : UpdateResult::kRejected) << observable;
    }
  }
}

TEST(EkfLimits, DoubtIsTheMeanContradictionOfTheLastMatches) {
  for (const int memory : {10, 25}) {
    EkfConfig config;
    config.nis_memory = memory;
    Ekf ekf(config, kBegin);
    ekf.setPose({}, {0.03, 0.03, 0.03});
    ekf.updatePose(measured({0.2, 0.0, 0.0}, 0.04));
    const double contradiction = square(0.2) / (square(0.03) + square(0.04)) / 3.0;
    EXPECT_NEAR(ekf.nisRatio(), 1.0 + (contradiction - 1.0) / memory, 1e-9);
    ekf.setPose({}, {0.03, 0.03, 0.03});
    const double before = ekf.nisRatio();
    ekf.updatePose(measured({50.0, 0.0, 0.0}, 0.04));
    EXPECT_NEAR(ekf.nisRatio(), before + (100.0 - before) / memory, 1e-9) << "one scan counts for no more";
    Ekf sure(config, kBegin);
    sure.updatePose(measured({}));
    EXPECT_EQ(sure.nisRatio(), 1.0) << "never below";
  }
}

TEST(EkfLimits, ThePoseIsMovedOnNoLongerThanTheWheelsReportOrMaxCoast) {
  for (const auto& [interval, seconds] : {std::pair(0.2, 0.5), std::pair(0.8, 0.8), std::pair(3.0, 2.0)}) {
    Ekf ekf(kConfig, kBegin);
    ekf.updateWheels({1.0, 0, 0}, true, fromSeconds(interval), std::nullopt);
    const double speed = ekf.twist().vx;
    ekf.predict(kBegin + milliseconds(2000));
    EXPECT_NEAR(ekf.pose().x, seconds * speed, 1e-9) << interval;
  }
}

TEST(EkfLimits, AMeanOverALongIntervalIsNotOffByMoreThanTwoSecondsWalk) {
  const auto after = [](double interval) {
    Ekf ekf = standing();
    const double before = variance(ekf, Ekf::kSpeed);
    ekf.updateWheels({60.0, 0, 0}, true, fromSeconds(interval), std::nullopt);  // no robot: it is not used
    return variance(ekf, Ekf::kSpeed) - before;
  };
  EXPECT_NEAR(after(1.0), square(kConfig.acceleration_noise) * 1.0, 1e-9);
  EXPECT_NEAR(after(2.0), square(kConfig.acceleration_noise) * 2.0, 1e-9);
  EXPECT_NEAR(after(9.0), square(kConfig.acceleration_noise) * 2.0, 1e-9);
}

TEST(EkfLimits, AHeldTwistIsKnownAsWellAsOneSampleAndForgetsWhereItCameFrom) {
  Ekf ekf(kConfig, kBegin);
  ekf.updateWheels({0.4, 0, 0.2}, true, milliseconds(20), std::nullopt);
  ekf.predict(kBegin + milliseconds(100));
  ASSERT_NE(ekf.covariance()(Ekf::kX, Ekf::kSpeed), 0.0);
  const Ekf before = ekf;
  ekf.holdTwist({0.6, 0.3, -0.1}, true);
  EXPECT_EQ(ekf.twist().vx, 0.6);
  EXPECT_EQ(ekf.twist().vy, 0.0) << "the base cannot move sideways";
  EXPECT_EQ(ekf.twist().omega, -0.1);
  EXPECT_NEAR(variance(ekf, Ekf::kSpeed), square(kConfig.wheel_speed_sigma), 1e-15);
  EXPECT_NEAR(variance(ekf, Ekf::kTurnRate), square(kConfig.wheel_turn_rate_sigma), 1e-15);
  for (const auto state : {Ekf::kX, Ekf::kY, Ekf::kTheta, Ekf::kGyroBias}) {
    EXPECT_EQ(ekf.covariance()(state, Ekf::kSpeed), 0.0);
    EXPECT_EQ(ekf.covariance()(state, Ekf::kTurnRate), 0.0);
  }
  EXPECT_EQ(ekf.pose(), before.pose());
  ekf = before;
  ekf.holdTwist({0.6, 0.0, -0.1}, false);
  EXPECT_EQ(ekf.twist().omega, before.twist().omega) << "the wheels do not tell it";
}

TEST(EkfLimits, AHolonomicBaseHoldsItsLateralSpeedToo) {
  EkfConfig config;
  config.holonomic = true;
  Ekf ekf(config, kBegin);
  ekf.holdTwist({0.6, 0.3, -0.1}, true);
  EXPECT_EQ(ekf.twist().vy, 0.3);
  EXPECT_NEAR(variance(ekf, Ekf::kLateralSpeed), square(config.wheel_speed_sigma), 1e-15);
}

TEST(EkfLimits, BeginsWithTheBiasThatIsKnown) {
  EkfConfig config;
  config.initial_gyro_bias = 0.03;
  config.initial_gyro_bias_sigma = 0.007;
  const Ekf ekf(config, kBegin, {1, 2, 3});
  EXPECT_EQ(ekf.gyroBias(), 0.03);
  EXPECT_NEAR(variance(ekf, Ekf::kGyroBias), square(0.007), 1e-15);
  EXPECT_EQ(ekf.pose(), (Pose2{1, 2, 3}));
}

TEST(EkfLimits, WheelsThatRestAreAcceptedAtOnceWhileTheBiasIsUnknown) {
  const auto rests = [](double bias_sigma, int ms, bool gyro) {
    EkfConfig config;
    config.initial_gyro_bias_sigma = 0.02;
    Ekf ekf(config, kBegin);
    if (bias_sigma < 0.02) {  // it has learned it at a rest before
      for (int i = 0; i < 4000 && std::sqrt(variance(ekf, Ekf::kGyroBias)) > bias_sigma; ++i) {
        ekf.updateWheels({}, true, milliseconds(10), std::nullopt);
        ekf.updateGyro(0.01);
        ekf.predict(ekf.stamp() + milliseconds(10));
      }
    }
    ekf.updateWheels({0.5, 0, 0}, true, milliseconds(10), std::nullopt);  // it drives, and stands again
    const Timestamp stands = ekf.stamp() + milliseconds(10);
    ekf.predict(stands);
    while (ekf.stamp() <= stands + milliseconds(ms - 10)) {
      ekf.updateWheels({}, true, milliseconds(10), std::nullopt);
      if (gyro) ekf.updateGyro(0.01);
      ekf.predict(ekf.stamp() + milliseconds(10));
    }
    return ekf.standstill();
  };
  EXPECT_TRUE(rests(0.02, 10, true)) << "the bias is unknown";
  EXPECT_FALSE(rests(0.02, 390, false)) << "no gyro, no bias";
  EXPECT_TRUE(rests(0.02, 410, false));
  EXPECT_FALSE(rests(0.002, 390, true));
  EXPECT_TRUE(rests(0.002, 410, true));
}

TEST(EkfLimits, APredictionThatIsDoubtedLosesThePoseFasterByAsMuch) {
  Ekf sure(kConfig, kBegin);
  sure.setPose({}, {0.03, 0.03, 0.03});
  Ekf unsure = sure;
  unsure.updatePose(measured({0.2, 0.0, 0.0}, 0.04));
  const double more = (unsure.nisRatio() - 1.0) * 0.2;  // [s]
  ASSERT_GT(more, 0.05);
  const auto lost = [](Ekf& ekf, Ekf::Index i) {
    Ekf next = ekf;
    next.predict(kBegin + milliseconds(200));
    return variance(next, i) - variance(ekf, i);
  };
  for (const auto& [i, drift] : {std::pair(Ekf::kX, kConfig.translation_drift),
                                 {Ekf::kY, kConfig.translation_drift},
                                 {Ekf::kTheta, kConfig.rotation_drift}})
    EXPECT_NEAR(lost(unsure, i) - lost(sure, i), more * square(drift), 1e-8) << i;
}

}  // namespace
}  // namespace slam::ekf_limits_test
