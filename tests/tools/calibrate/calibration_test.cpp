// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/calibration.hpp"

#include <array>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <utility>

#include "tools/calibrate/motions.hpp"

namespace slam::calibration_test {
namespace {

using test::Drive;
using test::kBelieved;
using test::kRobot;
using test::MotionMaker;
using testing::ElementsAre;

constexpr std::array<double, 6> kTolerances{1e-4, 1e-4, 3e-3, 5e-3, 5e-3, 5e-3};  // [m, m, m, m, m, rad]

void expectRobot(const RobotGeometry& geometry) {
  const RobotGeometry::Vector error = geometry.vector() - kRobot.vector();
  for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(error[i]), kTolerances[static_cast<std::size_t>(i)]) << i;
}

TEST(Calibration, IntervalsHoldTheTruthAsOftenAsTheirLevel) {
  constexpr int kSeeds = 200;
  std::array<int, 6> held{};
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Calibration result = calibrate(MotionMaker(seed).make(Drive::kVaried, 60), kBelieved);
    ASSERT_EQ(result.status, CalibrationStatus::kDone);
    const RobotGeometry::Vector error = result.geometry.vector() - kRobot.vector();
    for (int i = 0; i < 6; ++i) {
      held[static_cast<std::size_t>(i)] +=
          std::abs(error[i]) < 1.96 * result.sigma(static_cast<RobotGeometry::Index>(i));
    }
  }
  for (const int count : held) {
    EXPECT_GE(count, 0.90 * kSeeds);
    EXPECT_LE(count, 0.99 * kSeeds);
  }
}

TEST(Calibration, WidensTheIntervalsWhereResidualsShowMoreNoiseThanClaimed) {
  const Calibration claimed = calibrate(MotionMaker(1).make(Drive::kVaried, 100), kBelieved);
  const Calibration noisier = calibrate(MotionMaker(1, 3.0).make(Drive::kVaried, 100), kBelieved);
  EXPECT_NEAR(noisier.translation_noise, 3.0, 0.6);
  EXPECT_NEAR(noisier.rotation_noise, 3.0, 0.6);
  for (int i = 0; i < 6; ++i) {
    const auto index = static_cast<RobotGeometry::Index>(i);
    EXPECT_NEAR(noisier.sigma(index) / claimed.sigma(index), 3.0, 0.8);
  }
  EXPECT_NEAR(claimed.translation_residual, test::kTranslationSigma * std::sqrt(2.0), 5e-4);
  EXPECT_NEAR(claimed.rotation_residual, test::kRotationSigma, 2e-4);
}

TEST(Calibration, RejectsSlipOfAThirdOfTheMotions) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    auto motions = MotionMaker(seed).make(Drive::kVaried, 60);
    for (std::size_t i = 0; i < motions.size(); i += 3) MotionMaker::slip(motions[i]);
    const Calibration result = calibrate(motions, kBelieved);
    ASSERT_EQ(result.status, CalibrationStatus::kDone);
    EXPECT_GE(result.rejected, 20);
    EXPECT_LE(result.rejected, 23);
    EXPECT_EQ(result.used + result.rejected, 60);
    expectRobot(result.geometry);
  }
}

TEST(Calibration, DoesNotTakeSlipOnTheStraightForATrackWithoutEnd) {
  auto motions = MotionMaker(1).make(Drive::kStraight, 45);
  for (std::size_t i = 0; i < 15; ++i) MotionMaker::slip(motions[i]);
  for (const LidarMotion& turn : MotionMaker(2).make(Drive::kOnTheSpot, 8)) motions.push_back(turn);
  const Calibration result = calibrate(motions, kBelieved);
  ASSERT_EQ(result.status, CalibrationStatus::kDone);
  EXPECT_EQ(result.rejected, 15);
  EXPECT_NEAR(result.geometry.track, kRobot.track, 2e-3);
}

TEST(Calibration, IsExactWithoutNoise) {
  const Calibration result = calibrate(MotionMaker(1, 0.0).make(Drive::kVaried, 20), kBelieved);
  ASSERT_EQ(result.status, CalibrationStatus::kDone);
  EXPECT_EQ(result.rejected, 0);
  EXPECT_TRUE(result.geometry.vector().isApprox(kRobot.vector(), 1e-8));
  EXPECT_DOUBLE_EQ(result.translation_noise, 1.0) << "never surer than the motions claim";
}

TEST(Calibration, OfStraightDrivingKeepsWhatItCannotSee) {
  const Calibration result = calibrate(MotionMaker(1).make(Drive::kStraight, 60), kBelieved);
  EXPECT_EQ(result.status, CalibrationStatus::kPartly);
  EXPECT_EQ(result.drive, DriveKind::kStraight);
  EXPECT_THAT(result.determined, ElementsAre(true, true, false, false, false, true));
  EXPECT_NEAR(result.geometry.left_radius, kRobot.left_radius, 1e-4);
  EXPECT_NEAR(result.geometry.right_radius, kRobot.right_radius, 1e-4);
  EXPECT_NEAR(result.geometry.T_base_lidar.theta, kRobot.T_base_lidar.theta, 3e-3);
  EXPECT_NEAR(result.geometry.track, kBelieved.track, 1e-3);
  EXPECT_NEAR(result.geometry.T_base_lidar.x, kBelieved.T_base_lidar.x, 1e-3);
}

TEST(Calibration, DoesNotTakeSlipForTurns) {
  auto motions = MotionMaker(1).make(Drive::kStraight, 60);
  for (std::size_t i = 0; i < 12; ++i) MotionMaker::slip(motions[i]);
  const Calibration result = calibrate(motions, kBelieved);
  EXPECT_EQ(result.status, CalibrationStatus::kPartly);
  EXPECT_EQ(result.drive, DriveKind::kStraight);
  EXPECT_EQ(result.rejected, 12);
  EXPECT_THAT(result.determined, ElementsAre(true, true, false, false, false, true));
}

TEST(Calibration, OfTurningOnTheSpotOrOneArcIsPartial) {
  const Calibration spot = calibrate(MotionMaker(1).make(Drive::kOnTheSpot, 60), kBelieved);
  EXPECT_EQ(spot.status, CalibrationStatus::kPartly);
  EXPECT_EQ(spot.drive, DriveKind::kOnTheSpot);
  EXPECT_FALSE(spot.determined[RobotGeometry::kTrack]);
  EXPECT_FALSE(spot.determined[RobotGeometry::kLidarYaw]);

  const Calibration arc = calibrate(MotionMaker(1).make(Drive::kOneArc, 60), kBelieved);
  EXPECT_EQ(arc.status, CalibrationStatus::kPartly);
  EXPECT_EQ(arc.drive, DriveKind::kOneArc);
}

TEST(Calibration, RefusesTooFewMotionsAndContradictions) {
  EXPECT_EQ(calibrate(MotionMaker(1).make(Drive::kVaried, 9), kBelieved).status, CalibrationStatus::kTooFew);
  EXPECT_EQ(calibrate({}, kBelieved).status, CalibrationStatus::kTooFew);

  auto swapped = MotionMaker(1).make(Drive::kVaried, 60);
  for (LidarMotion& motion : swapped) {
    for (WheelStep& step : motion.wheels) std::swap(step.left, step.right);
  }
  EXPECT_EQ(calibrate(swapped, kBelieved).status, CalibrationStatus::kContradicted);
}

TEST(Calibration, GivesTheSameForTheSameMotions) {
  const auto motions = MotionMaker(1).make(Drive::kVaried, 60);
  EXPECT_EQ(calibrate(motions, kBelieved).geometry.vector(), calibrate(motions, kBelieved).geometry.vector());
}

TEST(Calibration, AcceptsNoRobotOfThriceTheSizeThatIsConfigured) {
  const auto statusAt = [](double factor) {
    RobotGeometry small = kBelieved;
    small.left_radius /= factor;
    small.right_radius /= factor;
    small.track /= factor;
    return calibrate(MotionMaker(1).make(Drive::kVaried, 60), small).status;
  };
  EXPECT_EQ(statusAt(2.8), CalibrationStatus::kDone);
  EXPECT_EQ(statusAt(3.2), CalibrationStatus::kContradicted);
}

TEST(Calibration, RejectsWhatLiesBeyondItsGateAndNothingElse) {
  const CalibrationConfig config;
  for (const auto& [share, rejected] : {std::pair(0.8, 0), {1.3, 5}}) {
    auto motions = MotionMaker(1, 0.0).make(Drive::kVaried, 60);
    for (std::size_t i = 0; i < 5; ++i)
      motions[i].T_begin_end.x += std::sqrt(share * config.gate) * test::kTranslationSigma;
    EXPECT_EQ(calibrate(motions, kBelieved).rejected, rejected) << share;
  }
}

}  // namespace
}  // namespace slam::calibration_test
