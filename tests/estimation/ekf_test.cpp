// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/ekf.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "support/allocations.hpp"
#include "support/simulated/robot.hpp"

namespace slam::ekf_test {
namespace {

using std::chrono::milliseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const EkfConfig kConfig;
constexpr double kWheelNoise = 0.0002;  // [m, rad] of each sample

EkfConfig holonomic() {
  EkfConfig config;
  config.holonomic = true;
  return config;
}

/// A base that cannot move sideways has no lateral speed, and knows it for sure: the rest must be positive definite.
void expectHealthy(const Ekf& ekf, const char* after, bool is_holonomic = false) {
  ASSERT_TRUE(ekf.state().allFinite()) << after << ": " << ekf.state().transpose();
  if (!is_holonomic) {
    ASSERT_EQ(ekf.state()[Ekf::kLateralSpeed], 0.0) << after;
    ASSERT_TRUE(ekf.covariance().row(Ekf::kLateralSpeed).isZero(0.0)) << after << '\n' << ekf.covariance();
  }
  const int size = is_holonomic ? 7 : 6;
  const Eigen::MatrixXd P = ekf.covariance().topLeftCorner(size, size);
  ASSERT_TRUE(P.allFinite()) << after << '\n' << P;
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  ASSERT_GT(P.diagonal().minCoeff(), 0.0) << after << '\n' << P;
  const Eigen::VectorXd inverse = sigma.cwiseInverse();
  const Eigen::MatrixXd correlation =
      inverse.asDiagonal() * P * inverse.asDiagonal();  // of one scale whatever the units
  ASSERT_LT((correlation - correlation.transpose()).cwiseAbs().maxCoeff(), 1e-9) << after << '\n' << correlation;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation, Eigen::EigenvaluesOnly);
  ASSERT_GT(solver.eigenvalues().minCoeff(), -1e-12) << after << '\n' << correlation;  // -rounding
}

/// Drives a filter with wheels at 50 Hz and a gyro at 100 Hz.
struct Drive : test::SimulatedRobot {
  Eigen::Vector3d twist{0, 0, 0};
  Ekf ekf;
  bool turn_rate_known = true;
  std::optional<double> before, newest;  // [rad/s] the gyro's last readings

  explicit Drive(const EkfConfig& config = kConfig) : SimulatedRobot(test::Room{}), ekf(config, now) {
    gyro.per_step = 2;
  }

  void run(double seconds) { SimulatedRobot::run(seconds, twist, *this); }
  /// To a stand, at 5 m/s^2.
  void brake() {
    while (twist.head<2>().norm() > 0.0) {
      const double left = 1.0 - 5.0 * toSeconds(kStep) / twist.head<2>().norm();
      twist *= left > 1e-6 ? left : 0.0;
      run(toSeconds(kStep));
    }
  }
  void add(const WheelSample& sample) {
    ekf.predict(sample.stamp);
    ekf.updateWheels({wheels.twist.x(), wheels.twist.y(), wheels.twist.z()}, turn_rate_known, kStep,
                     before ? std::optional((*before + *newest) / 2) : newest);
  }
  void add(const ImuSample& sample) {
    ekf.predict(sample.stamp);
    ekf.updateGyro(sample.gyro.z());
    before = std::exchange(newest, sample.gyro.z());
  }
};

Eigen::Matrix3d randomRotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

PoseMeasurement measured(const Pose2& pose, const Eigen::Vector3d& sigma) {
  PoseMeasurement measurement;
  measurement.T_map_base = pose;
  measurement.covariance = sigma.array().square().matrix().asDiagonal();
  return measurement;
}

class EkfOfEitherBase : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Holonomic, EkfOfEitherBase, testing::Bool());

TEST_P(EkfOfEitherBase, StaysFiniteSymmetricAndPositiveDefiniteUnderAnyInput) {
  const EkfConfig config = GetParam() ? holonomic() : kConfig;
  constexpr double kExtremes[] = {0.0,   -0.0,  1e-300, -1e-12, 1e6,
                                  -1e12, 1e150, 1e200,  -1e300, std::numeric_limits<double>::max(),
                                  kNan,  kInf,  -kInf};
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal;
    const double wild = seed <= 5 ? 0.0 : 0.05;  // share of extreme values
    const auto value = [&](double scale) {
      return uniform(random) < wild ? kExtremes[random() % std::size(kExtremes)] : scale * normal(random);
    };
    Ekf ekf(config, Timestamp(milliseconds(1000)));
    ekf.predict(ekf.stamp() + milliseconds(1));
    for (int step = 0; step < 2000; ++step) {
      const char* what = "predict";
      switch (random() % 5) {
        case 0:
          ekf.predict(ekf.stamp() +
                      fromSeconds(wild > 0 && random() % 50 == 0 ? 1e4 * normal(random) : 0.05 * uniform(random)));
          break;
        case 1:
          what = "updateWheels";
          ekf.updateWheels({value(0.5), value(0.01), value(1.0)}, random() % 4 != 0,
                           fromSeconds(random() % 20 == 0 ? 0.0 : 0.1 * uniform(random)),
                           random() % 2 == 0 ? std::optional(value(1.0)) : std::nullopt);
          break;
        case 2:
          what = "updateGyro";
          ekf.updateGyro(value(1.0));
          break;
        case 3: {
          what = "updatePose";
          std::uniform_real_distribution<double> sigma(0.005, 0.1);
          PoseMeasurement measurement = measured(ekf.pose() * Pose2{value(0.05), value(0.05), value(0.02)},
                                                 {sigma(random), sigma(random), sigma(random)});
          measurement.directions = randomRotation(random);
          measurement.observable = static_cast<int>(random() % 4);
          if (random() % 20 == 0) measurement.covariance *= 1e-8;                      // nearly exact
          if (uniform(random) < wild) measurement.covariance *= std::abs(value(1.0));  // none, endless or no number
          ekf.updatePose(measurement);
          break;
        }
        default:
          what = "setPose";
          if (random() % 20 == 0) ekf.setPose({normal(random), normal(random), 3 * normal(random)}, {0.1, 0.2, 0.3});
      }
      expectHealthy(ekf, what, GetParam());
      if (testing::Test::HasFatalFailure()) FAIL() << "seed " << seed << " step " << step;
    }
  }
}

TEST(Ekf, NumbersThatAreNoneChangeNothing) {
  Drive drive;
  drive.twist.x() = 0.3;
  drive.run(1.0);
  const auto changesNothing = [&](auto&& update) {
    Ekf ekf = drive.ekf;
    return update(ekf) != UpdateResult::kFused && ekf.state() == drive.ekf.state() &&
           ekf.covariance() == drive.ekf.covariance();
  };
  for (const double bad : {kNan, kInf, -kInf}) {
    const auto wheels = [](const Twist2& twist) {
      return [=](Ekf& ekf) { return ekf.updateWheels(twist, true, milliseconds(20), 0.0); };
    };
    const auto match = [](const Pose2& pose, const Eigen::Vector3d& sigma) {
      return [=](Ekf& ekf) { return ekf.updatePose(measured(pose, sigma)); };
    };
    EXPECT_TRUE(changesNothing([&](Ekf& ekf) { return ekf.updateGyro(bad); })) << bad;
    EXPECT_TRUE(changesNothing(wheels({bad, 0, 0}))) << bad;
    EXPECT_TRUE(changesNothing(wheels({0, 0, bad}))) << bad;
    EXPECT_TRUE(changesNothing(match({bad, 0, 0}, {0.1, 0.1, 0.1}))) << bad;
    EXPECT_TRUE(changesNothing(match({0, 0, bad}, {0.1, 0.1, 0.1}))) << bad;
    EXPECT_TRUE(changesNothing(match(drive.ekf.pose(), {bad, 0.1, 0.1}))) << bad;
  }
}

TEST(Ekf, LearnsTheGyroBiasAtStandstillFromNoisyReadings) {
  Drive drive;
  drive.gyro.bias = 0.02;
  drive.gyro.sigma = 0.003;
  drive.run(20.0);
  EXPECT_TRUE(drive.ekf.standstill());
  EXPECT_GT(drive.ekf.counters().standstill_updates, 100U);
  EXPECT_NEAR(drive.ekf.gyroBias(), 0.02, 5e-4);
  EXPECT_LT(std::sqrt(drive.ekf.covariance()(Ekf::kGyroBias, Ekf::kGyroBias)), 2e-3);
  const Pose2 rested = drive.ekf.pose();
  drive.run(60.0);  // the heading then stays although the gyro says 69 degrees
  EXPECT_NEAR(drive.ekf.pose().theta, rested.theta, 0.01);
  EXPECT_LT(between(rested, drive.ekf.pose()).translation().norm(), 0.005);
}

TEST(Ekf, FollowsANoisyArc) {
  Drive drive;
  drive.twist = {0.4, 0.0, 0.3};
  drive.wheels.sigma = drive.wheels.turn_sigma = kWheelNoise;
  drive.gyro.sigma = 0.005;
  drive.run(1.0);
  const Pose2 start = drive.ekf.pose();
  drive.run(10.0);
  const Pose2 error = between(start * exp({4.0, 0.0, 3.0}), drive.ekf.pose());
  EXPECT_LT(error.translation().norm(), 0.04);
  EXPECT_LT(std::abs(error.theta), 0.02);
  EXPECT_FALSE(drive.ekf.slip());
  EXPECT_FALSE(drive.ekf.standstill());
  EXPECT_EQ(drive.ekf.counters().wheels_rejected + drive.ekf.counters().gyro_rejected, 0U);
}

TEST(Ekf, MovesAlongTheArcOfItsTwistBetweenSamples) {
  Drive drive;
  drive.twist = {0.5, 0.0, -1.0};
  drive.run(2.0);
  const Pose2 start = drive.ekf.pose();
  const Twist2 twist = drive.ekf.twist();
  EXPECT_NEAR(twist.vx, 0.5, 1e-3);
  EXPECT_NEAR(twist.omega, -1.0, 2e-2);
  for (const double seconds : {0.1, 0.3}) {
    Ekf coasting = drive.ekf;
    coasting.predict(coasting.stamp() + fromSeconds(seconds));
    const Pose2 error = between(start * exp(seconds * Eigen::Vector3d{twist.vx, 0, twist.omega}), coasting.pose());
    EXPECT_LT(error.vector().cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Ekf, AnUncertainHeadingBecomesAnUncertainPlace) {
  Drive drive;
  drive.twist.x() = 0.5;
  drive.run(0.5);
  drive.ekf.setPose({1, 2, 0.8}, {0.01, 0.01, 0.1});
  drive.run(4.0);  // 2 m straight ahead: sideways sigma of 2 m * 0.1 rad
  const Eigen::Vector2d sideways{-std::sin(0.8), std::cos(0.8)};
  const double variance = sideways.dot(drive.ekf.covariance().topLeftCorner<2, 2>() * sideways);
  EXPECT_GT(std::sqrt(variance), 0.2);
  EXPECT_LT(std::sqrt(variance), 0.3);
}

TEST(Ekf, AnUncertainTwistBecomesAnUncertainPose) {
  Ekf ekf(kConfig);
  ekf.setPose({1, 2, 0}, {0.01, 0.01, 0.01});
  const Ekf::Matrix before = ekf.covariance();
  ekf.predict(ekf.stamp() + milliseconds(200));
  const Ekf::Matrix& after = ekf.covariance();
  EXPECT_NEAR(after(Ekf::kX, Ekf::kX), 1e-4 + 0.04 * before(Ekf::kSpeed, Ekf::kSpeed), 1e-5);  // + drift
  EXPECT_NEAR(after(Ekf::kTheta, Ekf::kTheta), 1e-4 + 0.04 * before(Ekf::kTurnRate, Ekf::kTurnRate), 1e-5);
  EXPECT_NEAR(after(Ekf::kX, Ekf::kSpeed), 0.2 * before(Ekf::kSpeed, Ekf::kSpeed), 1e-9);
  EXPECT_NEAR(after(Ekf::kTheta, Ekf::kTurnRate), 0.2 * before(Ekf::kTurnRate, Ekf::kTurnRate), 1e-9);
}

TEST(Ekf, AHolonomicBaseIsFollowedSideways) {
  static const EkfConfig config = holonomic();
  Drive drive(config);
  drive.twist = {0.0, 0.4, 0.0};
  drive.wheels.sigma = drive.wheels.turn_sigma = kWheelNoise;
  drive.gyro.sigma = 0.005;
  drive.run(0.5);
  drive.ekf.setPose({0, 0, 0.6}, {0.01, 0.01, 0.01});
  drive.run(5.0);  // 2 m to the left
  const Pose2 moved = between(Pose2{0, 0, 0.6}, drive.ekf.pose());
  EXPECT_NEAR(moved.y, 2.0, 0.05);
  EXPECT_NEAR(moved.x, 0.0, 0.05);
  EXPECT_NEAR(drive.ekf.twist().vy, 0.4, 0.03);
  drive.brake();
  drive.wheels.sigma = drive.wheels.turn_sigma = 0.0;
  drive.run(2.0);
  EXPECT_NEAR(drive.ekf.twist().vy, 0.0, 1e-3) << "and stands when it stands";
  EXPECT_TRUE(drive.ekf.standstill());
}

TEST(Ekf, AHolonomicBaseOnACircleFacesItsCentre) {
  static const EkfConfig config = holonomic();
  Drive drive(config);
  drive.twist = {0.0, 0.5, -0.5};
  drive.run(0.5);
  drive.ekf.setPose({1, 0, 0}, {0.01, 0.01, 0.01});  // the centre is 1 m ahead, to the left is round it clockwise
  for (int i = 0; i < 10; ++i) {
    drive.run(0.5);
    const Pose2 pose = drive.ekf.pose();
    EXPECT_NEAR(std::hypot(pose.x - 2.0, pose.y), 1.0, 0.02);
  }
}

TEST(Ekf, ABaseThatCannotMoveSidewaysTakesNoWordOfIt) {
  Drive straight, drifting;
  straight.twist = {0.5, 0.0, 0.0};
  drifting.twist = {0.5, 0.2, 0.0};
  straight.run(3.0);
  drifting.run(3.0);
  EXPECT_EQ(straight.ekf.state(), drifting.ekf.state());
  EXPECT_EQ(straight.ekf.covariance(), drifting.ekf.covariance());
}

/// Wheels at 0.5 m/s whose counters stop from one sample to the next, and scans that see the robot drive on or stand.
/// @param seen the scans see the way along
Drive stoppedAtOnce(bool drives_on, bool seen) {
  Drive drive;
  drive.twist.x() = 0.5;
  drive.run(2.0);
  drive.ekf.setPose({0, 0, 0}, {0.005, 0.005, 0.005});
  drive.twist.x() = 0.0;
  for (int scan = 1; scan <= 15; ++scan) {
    drive.run(0.2);
    PoseMeasurement match = measured({drives_on ? 0.1 * scan : 0.0, 0.0, 0.0}, {0.005, 0.005, 0.005});
    match.stamp = drive.ekf.stamp();
    if (!seen) {
      match.directions.col(0) = Eigen::Vector3d::UnitY();
      match.directions.col(1) = Eigen::Vector3d::UnitZ();
      match.observable = 2;
    }
    drive.ekf.updatePose(match);
  }
  return drive;
}

TEST(Ekf, WheelsThatDieWhileTheRobotDrivesOnAreNotFollowed) {
  const Drive drive = stoppedAtOnce(true, true);
  EXPECT_TRUE(drive.ekf.wheelsDead());
  EXPECT_FALSE(drive.ekf.standstill());
  EXPECT_NEAR(drive.ekf.pose().x, 1.5, 0.02);
  EXPECT_NEAR(drive.ekf.twist().vx, 0.5, 0.1);
}

TEST(Ekf, WheelsThatStopAtOnceAreFollowedOnceScansShowThatTheRobotStands) {
  const Drive drive = stoppedAtOnce(false, true);
  EXPECT_FALSE(drive.ekf.wheelsDead());
  EXPECT_TRUE(drive.ekf.standstill());
  EXPECT_NEAR(drive.ekf.pose().x, 0.0, 0.02);
}

TEST(Ekf, WhereNoScanShowsTheWayAnAbruptStopLeavesItUncertain) {
  for (const bool drives_on : {true, false}) {
    const Drive drive = stoppedAtOnce(drives_on, false);
    const double off = drive.ekf.pose().x - (drives_on ? 1.5 : 0.0);
    EXPECT_LT(std::abs(off), 2.0 * std::sqrt(drive.ekf.covariance()(0, 0)));
    EXPECT_FALSE(drive.ekf.wheelsDead());
  }
}

TEST(Ekf, CoarseCountersAndTyresThatBrakeAreNoDeadWheels) {
  Drive braking;
  braking.twist.x() = 0.5;
  braking.run(2.0);
  braking.brake();
  braking.run(1.0);
  EXPECT_TRUE(braking.ekf.standstill());
  Drive coarse;  // one tick in five intervals
  for (int i = 0; i < 200; ++i) {
    coarse.twist.x() = i % 5 == 0 ? 1.0 : 0.0;
    coarse.run(toSeconds(Drive::kStep));
    EXPECT_FALSE(coarse.ekf.wheelsSilent());
  }
}

EkfConfig smooth() {
  EkfConfig config;
  config.smooth = true;
  return config;
}

TEST(Ekf, OfASmoothPoseStandstillGivesTheBiasAndMovesNothing) {
  const EkfConfig config = smooth();
  for (const EkfConfig* each : {&config, &kConfig}) {
    Drive drive(*each);
    drive.twist = {0.5, 0.0, 0.1};
    drive.gyro.bias = 0.05;  // from the first sample on: the bias is in the turn
    drive.run(20.0);
    drive.brake();
    const Pose2 before = drive.ekf.pose();
    drive.run(2.0);
    const Pose2 moved = between(before, drive.ekf.pose());
    EXPECT_NEAR(drive.ekf.gyroBias(), 0.05, 0.002);
    EXPECT_EQ(std::hypot(moved.x, moved.y) < 0.02 && std::abs(moved.theta) < 0.05, each->smooth) << moved.theta;
    expectHealthy(drive.ekf, "standstill");
  }
}

TEST(Ekf, ASmoothPoseDoesNotJumpWhenWheelsComeBack) {
  const EkfConfig config = smooth();
  for (const double speed : {0.0, 0.2, 0.5}) {
    Drive drive(config);
    drive.twist.x() = 0.5;
    drive.run(5.0);
    Ekf& ekf = drive.ekf;
    for (int i = 0; i < 1200; ++i) {
      ekf.updateGyro(0.0);
      ekf.predict(ekf.stamp() + milliseconds(10));
    }
    const Pose2 before = ekf.pose();
    ekf.updateWheels({speed, 0.0, 0.0}, true, milliseconds(20), 0.0);
    EXPECT_EQ(ekf.pose(), before) << "the new speed tells nothing of where the robot is";
    EXPECT_NEAR(ekf.twist().vx, speed, 0.02);
    expectHealthy(ekf, "wheels come back");
  }
}

TEST(Ekf, OfASmoothPoseWhatWasDrivenInSilenceIsLeftOut) {
  const EkfConfig config = smooth();
  Drive drive(config);
  drive.twist.x() = 0.5;
  drive.run(5.0);
  const Pose2 before = drive.ekf.pose();
  Ekf silent = drive.ekf;
  for (int i = 0; i < 1000; ++i) {
    silent.updateGyro(0.0);
    silent.predict(silent.stamp() + milliseconds(10));
  }
  EXPECT_NEAR(between(before, silent.pose()).x, 0.5 * config.max_coast, 0.02);

  Drive gap(config);
  gap.twist.x() = 0.5;
  gap.run(5.0);
  EXPECT_EQ(gap.ekf.updateWheels({0.5, 0.0, 0.0}, true, std::chrono::seconds(10), 0.0), UpdateResult::kUseless);
  gap.ekf.predict(gap.ekf.stamp() + std::chrono::seconds(10));
  EXPECT_LT(between(before, gap.ekf.pose()).x, 0.5 * config.max_coast + 0.02);

  Drive slow(config);  // whose wheels are never faster
  for (int i = 0; i < 4; ++i) {
    slow.ekf.updateWheels({0.5, 0.0, 0.0}, true, std::chrono::seconds(3), std::nullopt);
    slow.ekf.predict(slow.ekf.stamp() + std::chrono::seconds(3));
  }
  EXPECT_NEAR(slow.ekf.pose().x, 6.0, 0.1);
}

TEST(Ekf, LearnsTheGyroBiasAtTheFirstRestHoweverFarOffItIs) {
  for (const double bias : {0.09, -0.3, 0.49}) {
    Drive drive;
    drive.gyro.bias = bias;
    drive.gyro.sigma = 0.003;
    drive.run(2.0);
    EXPECT_NEAR(drive.ekf.gyroBias(), bias, 0.003);
    EXPECT_NEAR(drive.ekf.pose().theta, 0.0, 0.002);
    expectHealthy(drive.ekf, "bias");
    drive.twist.z() = 0.3;
    drive.wheels.turn_scale = 0.0;  // turned by hand: what is known of the bias stays
    drive.run(2.0);
    EXPECT_NEAR(drive.ekf.gyroBias(), bias, 0.01);
    EXPECT_NEAR(drive.ekf.pose().theta, 0.6, 0.05);
  }
  Drive beyond;
  beyond.gyro.bias = 0.7;  // no bias is so large
  beyond.run(2.0);
  EXPECT_NEAR(beyond.ekf.gyroBias(), 0.0, 0.02);
}

TEST(Ekf, TurnsByTheWheelsAtOnceWhereTheGyroIsLost) {
  Drive drive;
  drive.twist = {0.5, 0.0, 0.4};
  drive.run(2.0);
  ASSERT_TRUE(drive.ekf.gyroActive());
  drive.ekf.loseGyro();
  EXPECT_FALSE(drive.ekf.gyroActive());
  const Pose2 before = drive.ekf.pose();
  drive.ekf.updateWheels({0.5, 0.0, -0.4}, true, milliseconds(20), std::nullopt);
  drive.ekf.predict(drive.ekf.stamp() + milliseconds(20));
  EXPECT_NEAR(between(before, drive.ekf.pose()).theta, -0.008, 1e-3);
}

TEST(Ekf, TakesABiasFromElsewhereAndKeepsThePose) {
  Drive drive;
  drive.twist.x() = 0.5;
  drive.gyro.bias = 0.02;
  drive.run(5.0);
  const Pose2 before = drive.ekf.pose();
  const double turn_sigma = std::sqrt(drive.ekf.covariance()(Ekf::kTheta, Ekf::kTheta));
  drive.ekf.setGyroBias(0.02, 1e-6);
  EXPECT_EQ(before.vector(), drive.ekf.pose().vector());
  EXPECT_EQ(drive.ekf.gyroBias(), 0.02);
  EXPECT_NEAR(drive.ekf.covariance()(Ekf::kGyroBias, Ekf::kGyroBias), 1e-6, 1e-12);
  EXPECT_EQ(std::sqrt(drive.ekf.covariance()(Ekf::kTheta, Ekf::kTheta)), turn_sigma);
  expectHealthy(drive.ekf, "bias");
  drive.ekf.setGyroBias(kNan, 1e-6);
  drive.ekf.setGyroBias(0.5, 0.0);
  EXPECT_EQ(drive.ekf.gyroBias(), 0.02);
  drive.run(2.0);
  EXPECT_NEAR(between(before, drive.ekf.pose()).theta, 0.0, 0.002);
}

TEST(Ekf, DoesNotCoastForeverNorBackInTime) {
  Drive drive;
  drive.twist.x() = 1.0;
  drive.run(2.0);
  Ekf ekf = drive.ekf;
  ekf.predict(ekf.stamp() - milliseconds(100));
  EXPECT_EQ(ekf.stamp(), drive.ekf.stamp());
  EXPECT_EQ(ekf.state(), drive.ekf.state());
  EXPECT_EQ(ekf.covariance(), drive.ekf.covariance());

  ekf.predict(ekf.stamp() + milliseconds(30'000));
  EXPECT_NEAR(between(drive.ekf.pose(), ekf.pose()).x, kConfig.max_coast, 0.05);
  EXPECT_EQ(ekf.stamp(), drive.ekf.stamp() + milliseconds(30'000));
}

TEST(Ekf, FlagsSlippingWheelsAndDistrustsThem) {
  Drive drive;
  drive.twist.x() = 0.3;
  drive.gyro.sigma = 0.003;
  drive.run(2.0);
  ASSERT_FALSE(drive.ekf.slip());
  const auto speedVarianceAfterWheels = [&] {
    Ekf ekf = drive.ekf;
    ekf.updateWheels({0.3, 0, drive.wheels.spin.z()}, true, milliseconds(20), 0.0);
    return ekf.covariance()(Ekf::kSpeed, Ekf::kSpeed);
  };
  const double sure = speedVarianceAfterWheels();
  const double heading = drive.ekf.pose().theta;

  drive.wheels.spin.z() = 1.0;  // one wheel spins; the gyro knows that the robot does not turn
  drive.run(0.5);
  EXPECT_TRUE(drive.ekf.slip());
  EXPECT_GT(speedVarianceAfterWheels(), 10 * sure);
  drive.run(2.0);
  EXPECT_NEAR(drive.ekf.pose().theta, heading, 0.05);

  drive.wheels.spin.z() = 0.0;
  drive.run(2.0);
  EXPECT_FALSE(drive.ekf.slip());
}

TEST(Ekf, AWrongTrackWidthIsNoSlip) {
  Drive drive;
  drive.twist = {0.3, 0.0, 2.0};
  drive.wheels.turn_scale = 1.05;
  drive.gyro.sigma = 0.003;
  for (int i = 0; i < 500; ++i) {
    drive.run(0.02);
    ASSERT_FALSE(drive.ekf.slip()) << i;
  }
}

TEST(Ekf, WheelsNeverChangeTheGyroBias) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Drive drive;
  drive.twist = {0.5, 0.0, 0.5};
  drive.wheels.turn_scale = 0.9;  // a systematic error of the wheels
  drive.gyro.sigma = 0.005;
  for (int i = 0; i < 500; ++i) {
    drive.run(0.02);
    const Ekf before = drive.ekf;
    drive.ekf.updateWheels({0.5 + 0.1 * normal(random), 0, 0.45 + 0.1 * normal(random)}, true, milliseconds(20),
                           0.5 + 0.01 * normal(random));
    ASSERT_EQ(drive.ekf.gyroBias(), before.gyroBias());
    ASSERT_NEAR(drive.ekf.covariance()(Ekf::kGyroBias, Ekf::kGyroBias),
                before.covariance()(Ekf::kGyroBias, Ekf::kGyroBias), 1e-15);
  }
}

TEST(Ekf, ASystematicErrorOfTheWheelsDoesNotPassForAGyroBias) {
  Drive drive;
  drive.twist = {0.3, 0.0, 0.5};
  drive.wheels.turn_scale = 1.04;
  drive.gyro.sigma = 0.005;
  drive.run(20.0);
  EXPECT_NEAR(drive.ekf.gyroBias(), 0.0, 0.005);  // a quarter of the error
  const double before = drive.ekf.pose().theta;
  drive.run(2.0);  // nor does it reach the heading by way of the correlations
  EXPECT_NEAR(wrapAngle(drive.ekf.pose().theta - before) / 2.0, 0.5, 0.005);
}

TEST(Ekf, TurnsByTheWheelsOnlyWhenThereIsNoGyro) {
  Drive wheels_only;
  wheels_only.gyro.there = false;
  wheels_only.twist = {0.3, 0.0, 0.5};
  wheels_only.run(3.0);
  EXPECT_NEAR(wheels_only.ekf.twist().omega, 0.5, 0.01);

  Drive both;
  both.twist = {0.3, 0.0, 0.5};
  both.gyro.bias = 0.02;  // less than slip
  both.run(3.0);
  EXPECT_NEAR(both.ekf.pose().theta, 3.0 * 0.52, 0.03);

  Drive speed_only;
  speed_only.gyro.there = speed_only.turn_rate_known = false;
  speed_only.twist = {0.3, 0.0, 0.5};
  speed_only.run(3.0);
  EXPECT_EQ(speed_only.ekf.pose().theta, 0.0);
  EXPECT_NEAR(speed_only.ekf.twist().vx, 0.3, 0.01);
}

TEST(Ekf, GatesLetTheConfiguredShareOfGoodMeasurementsPass) {
  EkfConfig config;
  config.gate_probability = 0.9;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int observable = 1; observable <= 3; ++observable) {
    int rejected = 0;
    constexpr int kTrials = 4000;
    for (int i = 0; i < kTrials; ++i) {
      Ekf ekf(config);
      ekf.setPose({1, 2, 0.5}, {0.03, 0.04, 0.02});
      PoseMeasurement measurement = measured({1 + 0.05 * normal(random), 2 + std::hypot(0.04, 0.06) * normal(random),
                                              0.5 + std::hypot(0.02, 0.01) * normal(random)},
                                             {0.04, 0.06, 0.01});
      measurement.observable = observable;
      const UpdateResult result = ekf.updatePose(measurement);
      EXPECT_EQ(ekf.counters().poses_rejected, result == UpdateResult::kRejected ? 1U : 0U);
      EXPECT_EQ(ekf.counters().poses_fused, result == UpdateResult::kFused ? 1U : 0U);
      rejected += result == UpdateResult::kRejected;
    }
    EXPECT_NEAR(rejected, 0.1 * kTrials, 100) << observable;  // 5 sigma
  }
}

TEST(Ekf, AnOutlierIsCountedAndChangesNothing) {
  Drive drive;
  drive.twist.x() = 0.3;
  drive.run(1.0);
  drive.ekf.setPose({}, {0.02, 0.02, 0.01});
  const Ekf before = drive.ekf;
  EXPECT_EQ(drive.ekf.updatePose(measured({1.0, 0, 0}, {0.02, 0.02, 0.01})), UpdateResult::kRejected);
  EXPECT_EQ(drive.ekf.updateGyro(50.0), UpdateResult::kRejected);
  EXPECT_EQ(drive.ekf.counters().poses_rejected, before.counters().poses_rejected + 1);
  EXPECT_EQ(drive.ekf.counters().gyro_rejected, before.counters().gyro_rejected + 1);
  EXPECT_EQ(drive.ekf.state(), before.state());
  EXPECT_EQ(drive.ekf.covariance(), before.covariance());
}

TEST(Ekf, RefusedPosesAreAcceptedWhereTheyAgree) {
  for (const double wanders : {0.0, 0.25}) {  // [m] from scan to scan
    Ekf ekf(kConfig);
    ekf.setPose({}, {0.02, 0.02, 0.01});
    int refused = 0;
    while (refused < 10 &&
           ekf.updatePose(measured({1.0 + wanders * refused, 0, 0}, {0.02, 0.02, 0.01})) == UpdateResult::kRejected) {
      ++refused;
    }
    EXPECT_EQ(refused, wanders == 0.0 ? kConfig.max_rejected_poses : 10) << wanders;
    EXPECT_NEAR(ekf.pose().x, wanders == 0.0 ? 1.0 : 0.0, 0.01) << wanders;
  }
}

TEST(Ekf, RefusedPosesMayDifferByWhatSlippingWheelsMakeUp) {
  Drive drive;
  drive.twist.x() = 1.0;
  drive.run(1.0);
  drive.ekf.setPose({}, {0.02, 0.02, 0.01});
  int refused = 0;  // the robot is blocked: scans stay where the wheels go on
  for (; refused < 10; ++refused) {
    drive.run(0.2);
    if (drive.ekf.updatePose(measured({-1.0, 0, 0}, {0.02, 0.02, 0.01})) == UpdateResult::kFused) break;
  }
  EXPECT_EQ(refused, kConfig.max_rejected_poses);
  EXPECT_NEAR(drive.ekf.pose().x, -1.0, 0.05);
}

TEST(Ekf, APoseThatIsAcceptedMovesNothingAlongABlindDirection) {
  Ekf ekf(kConfig);
  ekf.setPose({}, {0.02, 0.02, 0.01});
  PoseMeasurement measurement = measured({1.0, 0.5, 0.1}, {0.02, 0.02, 0.01});
  measurement.directions << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // y and heading are seen, x is not
  measurement.observable = 2;
  measurement.bypass_gate = true;
  ASSERT_EQ(ekf.updatePose(measurement), UpdateResult::kFused);
  EXPECT_NEAR(ekf.pose().y, 0.5, 0.01);
  EXPECT_NEAR(ekf.pose().theta, 0.1, 0.01);
  EXPECT_NEAR(ekf.pose().x, 0.0, 1e-6);
  EXPECT_NEAR(std::sqrt(ekf.covariance()(0, 0)), 0.02, 1e-6);
}

TEST(Ekf, ABlindDirectionLearnsNothing) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    Ekf ekf(kConfig);
    const Pose2 pose{1, -2, 0.5};
    ekf.setPose(pose, {0.1, 0.2, 0.3});
    const Eigen::Matrix3d before = ekf.covariance().topLeftCorner<3, 3>();
    PoseMeasurement measurement = measured(pose, {0.02, 0.03, 0.01});
    measurement.directions = randomRotation(random);
    measurement.observable = 1 + i % 2;
    Eigen::Vector3d innovation = 0.05 * measurement.directions.col(0);
    for (int blind = measurement.observable; blind < 3; ++blind) innovation += 1.0 * measurement.directions.col(blind);
    measurement.T_map_base = Pose2::fromVector(pose.vector() + innovation);

    ASSERT_EQ(ekf.updatePose(measurement), UpdateResult::kFused);

    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d u = measurement.directions.col(j);
      const double variance = u.dot(ekf.covariance().topLeftCorner<3, 3>() * u);
      const double moved = u.dot(ekf.pose().vector() - pose.vector());
      if (j < measurement.observable) {
        EXPECT_LT(variance, 0.5 * u.dot(before * u));
      } else {
        EXPECT_NEAR(variance, u.dot(before * u), 1e-12);
        EXPECT_NEAR(moved, 0.0, 1e-12);
      }
      if (j == 0) {
        EXPECT_GT(moved, 0.02);
      }
    }
  }
}

/// A bare corridor without wheels: the prediction is off by metres along it, and which way it goes is known to a tenth
/// of a degree.
TEST(Ekf, ACorridorWhoseDirectionIsSlightlyOffGivesNothingOfTheWayAlongIt) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal(0.0, 0.002);
  Ekf ekf(kConfig);
  ekf.setPose({1.0, 0.0, 0.0}, {3.0, 0.01, 0.01});
  for (int i = 0; i < 70; ++i) {
    const double off = normal(random);  // [rad]
    PoseMeasurement measurement = measured({1.0, normal(random), 0.0}, {0.001, 0.001, 0.001});
    measurement.directions << -std::sin(off), 0, std::cos(off), std::cos(off), 0, std::sin(off), 0, 1, 0;
    measurement.observable = 2;
    ekf.updatePose(measurement);
  }
  EXPECT_NEAR(std::sqrt(ekf.covariance()(0, 0)), 3.0, 0.01);
  EXPECT_NEAR(ekf.pose().x, 1.0, 0.01);
  EXPECT_LT(std::sqrt(ekf.covariance()(1, 1)), 0.01);
}

TEST(Ekf, AMeasurementThatSeesNothingIsUseless) {
  Ekf ekf(kConfig);
  ekf.setPose({}, {0.1, 0.1, 0.1});
  const Ekf before = ekf;
  PoseMeasurement measurement = measured({0.05, 0.05, 0.05}, {0.01, 0.01, 0.01});
  measurement.observable = 0;
  EXPECT_EQ(ekf.updatePose(measurement), UpdateResult::kUseless);
  EXPECT_EQ(ekf.state(), before.state());
  EXPECT_EQ(ekf.covariance(), before.covariance());
}

TEST(Ekf, FusesTwoHeadingsAcrossTheHalfTurn) {
  Ekf ekf(kConfig);
  ekf.setPose({0, 0, 3.13}, {0.1, 0.1, 0.05});
  ASSERT_EQ(ekf.updatePose(measured({0, 0, -3.13}, {0.1, 0.1, 0.05})), UpdateResult::kFused);
  EXPECT_NEAR(std::abs(ekf.pose().theta), std::numbers::pi, 1e-6);  // half way
}

TEST(Ekf, AcceptsAConfirmedPoseOutsideItsGateAtOnce) {
  Drive drive;
  drive.run(10.0);
  PoseMeasurement measurement = measured({1.0, 0, 0}, {0.02, 0.02, 0.01});
  measurement.stamp = drive.ekf.stamp();
  measurement.bypass_gate = true;
  EXPECT_EQ(drive.ekf.updatePose(measurement), UpdateResult::kFused);
  EXPECT_NEAR(drive.ekf.pose().x, 1.0, 0.01);
  expectHealthy(drive.ekf, "confirmed");
}

TEST(Ekf, DoubtsAPredictionThatScansKeepContradicting) {
  Ekf honest(kConfig), contradicted(kConfig);
  for (int i = 1; i <= 40; ++i) {
    for (Ekf* ekf : {&honest, &contradicted}) {
      ekf->predict(Timestamp(std::chrono::milliseconds(200 * i)));
      ekf->updateWheels({.vx = 0.5, .omega = 0.0}, true, std::chrono::milliseconds(200), std::nullopt);
    }
    honest.updatePose(measured(honest.pose(), {0.02, 0.02, 0.01}));
    const Pose2 aside{contradicted.pose().x, contradicted.pose().y + 0.15, contradicted.pose().theta};
    contradicted.updatePose(measured(aside, {0.02, 0.02, 0.01}));
  }
  EXPECT_LT(honest.nisRatio(), 1.5);
  EXPECT_GT(contradicted.nisRatio(), 2.0);
}

TEST(Ekf, TakesASuddenChangeOfSpeedButNoImpossibleOne) {
  Drive drive;
  drive.run(10.0);
  const auto before = drive.ekf.counters().wheels_rejected;
  drive.ekf.updateWheels({.vx = 2.0, .omega = 0.0}, true, std::chrono::milliseconds(5), std::nullopt);
  EXPECT_NEAR(drive.ekf.twist().vx, 2.0, 0.1);
  EXPECT_EQ(drive.ekf.counters().wheels_rejected, before + 1);  // counted as a contradiction all the same
  drive.ekf.updateWheels({.vx = 60.0, .omega = 0.0}, true, std::chrono::milliseconds(5), std::nullopt);
  EXPECT_LT(drive.ekf.twist().vx, 3.0);
}

TEST(Ekf, SetPoseKeepsTheBiasAndSetsTheUncertainty) {
  Drive drive;
  drive.gyro.bias = 0.01;
  drive.run(10.0);
  const Ekf before = drive.ekf;
  drive.ekf.setPose({4, 5, 6}, {0.1, 0.2, 0.3});
  EXPECT_NEAR(drive.ekf.pose().x, 4, 1e-12);
  EXPECT_NEAR(drive.ekf.pose().y, 5, 1e-12);
  EXPECT_NEAR(drive.ekf.pose().theta, wrapAngle(6), 1e-12);
  const Eigen::Matrix3d expected = Eigen::Vector3d{0.01, 0.04, 0.09}.asDiagonal();
  EXPECT_LT((drive.ekf.covariance().topLeftCorner<3, 3>() - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(drive.ekf.gyroBias(), before.gyroBias());
  EXPECT_EQ(drive.ekf.covariance()(Ekf::kGyroBias, Ekf::kGyroBias),
            before.covariance()(Ekf::kGyroBias, Ekf::kGyroBias));
  expectHealthy(drive.ekf, "setPose");
}

TEST(Ekf, DoesNotAllocate) {
  Drive drive;
  EXPECT_EQ(test::allocationsDuring([&] {
              drive.run(2.0);
              drive.ekf.updatePose(measured(drive.ekf.pose(), {0.1, 0.1, 0.1}));
              drive.ekf.setPose({}, {0.1, 0.1, 0.1});
            }),
            0U);
}

}  // namespace
}  // namespace slam::ekf_test
