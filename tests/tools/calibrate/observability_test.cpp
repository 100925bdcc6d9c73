// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/observability.hpp"

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/calibrate/motions.hpp"

namespace slam::observability_test {
namespace {

using test::Drive;
using testing::ElementsAre;
using testing::HasSubstr;

Observability::Matrix informationOf(const std::vector<LidarMotion>& motions) {
  Observability::Matrix information = Observability::Matrix::Zero();
  for (const LidarMotion& motion : motions) {
    const auto J = predictMotion(test::kRobot, motion.wheels).jacobian;
    information += J.transpose() * motion.covariance.inverse() * J;
  }
  return information;
}

Observability observabilityOf(Drive drive) {
  return {informationOf(test::MotionMaker(3).make(drive, 60)), test::kRobot};
}

TEST(Observability, OfAVariedDriveIsFull) {
  const auto motions = test::MotionMaker(3).make(Drive::kVaried, 60);
  const Observability observability(informationOf(motions), test::kRobot);
  EXPECT_EQ(observability.weakDirections(), 0);
  EXPECT_THAT(observability.determined(), ElementsAre(true, true, true, true, true, true));
  EXPECT_TRUE(observability.covariance().isApprox(informationOf(motions).inverse(), 1e-6));
  EXPECT_EQ(driveKind(motions, test::kBelieved), DriveKind::kVaried);
}

// Radii and yaw show on the straight; track, x and y do not.
TEST(Observability, OfStraightDrivingLacksTrackAndPosition) {
  const Observability observability = observabilityOf(Drive::kStraight);
  EXPECT_EQ(observability.weakDirections(), 3);
  EXPECT_THAT(observability.determined(), ElementsAre(true, true, false, false, false, true));
}

// Free are: the size of wheels and track; turning the lidar and its place about the centre together; the centre itself
// along the axle, with the ratio of the radii.
TEST(Observability, OfTurningOnTheSpotLacksSizeAndDirection) {
  const Observability observability = observabilityOf(Drive::kOnTheSpot);
  EXPECT_EQ(observability.weakDirections(), 3);
  const auto determined = observability.determined();
  for (const auto open : {RobotGeometry::kLeftRadius, RobotGeometry::kRightRadius, RobotGeometry::kTrack,
                          RobotGeometry::kLidarY, RobotGeometry::kLidarYaw}) {
    EXPECT_FALSE(determined[open]) << open;
  }
}

TEST(Observability, OfOneArcIsPartial) {
  const Observability observability = observabilityOf(Drive::kOneArc);
  EXPECT_GT(observability.weakDirections(), 0);
  EXPECT_FALSE(observability.determined()[RobotGeometry::kTrack]);
}

TEST(Observability, StepsAlongDeterminedDirectionsOnly) {
  const auto motions = test::MotionMaker(3).make(Drive::kStraight, 60);
  const auto information = informationOf(motions);
  const RobotGeometry::Vector wanted = (RobotGeometry::Vector() << 1e-4, -1e-4, 0.1, 0.1, 0.1, 0.01).finished();
  const auto step = Observability(information, test::kRobot).solve(information, information * wanted);
  const RobotGeometry::Vector possible = (RobotGeometry::Vector() << 1e-4, -1e-4, 0.0, 0.0, 0.0, 0.01).finished();
  EXPECT_LT((step - possible).norm(), 1e-3);
}

TEST(Observability, WithoutInformationDeterminesNothing) {
  const Observability observability(Observability::Matrix::Zero(), test::kRobot);
  EXPECT_EQ(observability.weakDirections(), 6);
  EXPECT_THAT(observability.determined(), ElementsAre(false, false, false, false, false, false));
  EXPECT_TRUE(observability.solve(Observability::Matrix::Zero(), RobotGeometry::Vector::Ones()).isZero());
}

TEST(DriveKind, IsNamedFromNoisyMotions) {
  const auto kindOf = [](Drive drive) { return driveKind(test::MotionMaker(5).make(drive, 30), test::kBelieved); };
  EXPECT_EQ(kindOf(Drive::kStraight), DriveKind::kStraight);
  EXPECT_EQ(kindOf(Drive::kOnTheSpot), DriveKind::kOnTheSpot);
  EXPECT_EQ(kindOf(Drive::kOneArc), DriveKind::kOneArc);
}

TEST(DriveKind, ShowsHowToMendIt) {
  EXPECT_THAT(describe(DriveKind::kStraight), HasSubstr("turn both ways"));
  EXPECT_THAT(describe(DriveKind::kOnTheSpot), HasSubstr("drive some metres"));
  EXPECT_THAT(describe(DriveKind::kOneArc), HasSubstr("same arc"));
  EXPECT_THAT(describe(DriveKind::kVaried), HasSubstr("drive for longer"));
}

}  // namespace
}  // namespace slam::observability_test
