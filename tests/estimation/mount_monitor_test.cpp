// SPDX-License-Identifier: BSD-3-Clause
// Drives whose scans come from a lidar that is not where it is taken to be.
#include "estimation/mount_monitor.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace slam::mount_monitor_test {
namespace {

constexpr double kDegree = 0.017453292519943295;
const Eigen::Vector3d kPriorSigma(0.01, 0.01, 0.5 * kDegree);  // [m, m, rad]

struct Drive {
  Pose2 mount = {};            // E: from where the lidar is taken to sit to where it does, in base
  double wheels_scale = 1.0;   // [1]
  double way_noise = 0.002;    // [m] of each step, of wheels and scans
  double turn_noise = 0.0005;  // [rad] of each step, of the wheels
  double lag = 0.0;            // [1] share of a step by which the scans' ways come late in left turns
  bool only_left = false;      // no right turns
  int steps = 1000;
  unsigned seed = 1;

  /// Bends to either side, straight ways and turns on the spot, in steps of 0.1 m or 0.1 rad.
  MountMonitor driven() const {
    MountMonitor monitor(kPriorSigma.cwiseAbs2().asDiagonal());
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    Pose2 truth, odometry;
    for (int i = 0; i < steps; ++i) {
      const std::array kinds = {0, 1, only_left ? 0 : 2, 3, only_left ? 3 : 4};
      const int kind = kinds[static_cast<std::size_t>(i / 20 % 5)];
      const double way = kind < 3 ? 0.1 : 0.0, turn = kind == 1   ? 0.05
                                                      : kind == 2 ? -0.05
                                                      : kind == 3 ? 0.1
                                                      : kind == 4 ? -0.1
                                                                  : 0.0;
      const Pose2 step{way, 0.0, turn};
      truth = truth * step;
      odometry = odometry * Pose2{wheels_scale * way + way_noise * normal(random), way_noise * normal(random),
                                  turn + turn_noise * normal(random)};
      Pose2 matched = mount.inverse() * truth * mount;
      matched.x += way_noise * normal(random);
      matched.y += way_noise * normal(random);
      if (turn > 0.0) matched = matched * Pose2{-lag * way, lag * 0.05, 0.0};
      monitor.compare(odometry, matched, true);
    }
    return monitor;
  }
};

Eigen::Vector3d sigmas(const MountError& error) { return error.covariance.diagonal().cwiseSqrt(); }

void expectFound(const Drive& drive) {
  const MountError error = drive.driven().error();
  EXPECT_NEAR(error.mean.x(), drive.mount.x, 0.01);
  EXPECT_NEAR(error.mean.y(), drive.mount.y, 0.01);
  EXPECT_NEAR(error.mean.z(), drive.mount.theta, 0.3 * kDegree);
  const Eigen::Vector3d off = error.mean - drive.mount.vector();
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(off[i]), 4.0 * sigmas(error)[i]) << i;
  EXPECT_LT(sigmas(error).z(), 0.3 * kDegree);
  EXPECT_LT(sigmas(error).head<2>().maxCoeff(), 0.01);
}

TEST(MountMonitor, FindsAMountThatIsTurned) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    expectFound({.mount = {0.0, 0.0, 4.0 * kDegree}, .seed = seed});
    expectFound({.mount = {0.0, 0.0, -1.0 * kDegree}, .seed = seed});
  }
}

TEST(MountMonitor, FindsAMountThatIsShifted) {
  for (unsigned seed = 1; seed <= 5; ++seed) expectFound({.mount = {-0.064, 0.03, 0.0}, .seed = seed});
}

TEST(MountMonitor, TakesTheWheelsScaleForNoMount) {
  expectFound({.mount = {0.05, 0.0, 2.0 * kDegree}, .wheels_scale = 1.05});
}

TEST(MountMonitor, FindsNothingOnASoundRobot) {
  for (unsigned seed = 1; seed <= 5; ++seed) expectFound({.seed = seed});
}

TEST(MountMonitor, KeepsThePriorWhereTheWheelsSlipInTurns) {
  const MountError error = Drive{.mount = {0.09, 0.0, 2.0 * kDegree}, .turn_noise = 0.03}.driven().error();
  EXPECT_EQ(error.mean, Eigen::Vector3d::Zero());
  EXPECT_TRUE(sigmas(error).isApprox(kPriorSigma));
}

TEST(MountMonitor, IsUnsureOfATurnedMountFromTheFirstMetreOn) {
  for (const double degrees : {4.0, -4.0, 8.0}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const double yaw = degrees * kDegree;
      const MountError error = Drive{.mount = {0.0, 0.0, yaw}, .steps = 12, .seed = seed}.driven().error();
      EXPECT_GT(std::sqrt(error.secondMoment()(2, 2)), 0.7 * std::abs(yaw)) << degrees << ", seed " << seed;
    }
  }
}

TEST(MountMonitor, StaysNearThePriorOnTheFirstMetresOfASoundRobot) {
  for (const int steps : {8, 12, 20, 30}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const MountError error = Drive{.way_noise = 0.003, .steps = steps, .seed = seed}.driven().error();
      EXPECT_LT(std::sqrt(error.secondMoment()(2, 2)), 2.0 * kPriorSigma.z()) << steps << ", seed " << seed;
    }
  }
}

TEST(MountMonitor, KeepsThePriorWhereScansDoNotSeeAllDirections) {
  MountMonitor blind(kPriorSigma.cwiseAbs2().asDiagonal());
  for (int i = 0; i < 1000; ++i) blind.compare({0.1 * i, 0.0, 0.0}, {0.1 * i, 0.01 * i, 0.0}, false);
  EXPECT_EQ(blind.error().mean, Eigen::Vector3d::Zero());
}

TEST(MountMonitor, AContradictionOfLeftAndRightTurnsMakesItUnsure) {
  const MountError sound = Drive{}.driven().error(), lagging = Drive{.lag = 0.6}.driven().error();
  EXPECT_GT(sigmas(lagging).maxCoeff(), 2.0 * sigmas(sound).maxCoeff());
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(lagging.mean[i]), 3.0 * sigmas(lagging)[i]) << i;
}

TEST(MountMonitor, IsUnsureOfAnOffsetThatLeftTurnsAloneShow) {
  const MountError error = Drive{.mount = {-0.1, 0.0, 0.0}, .only_left = true}.driven().error();
  EXPECT_LT(std::abs(error.mean.x()), 1.2 * sigmas(error).x());
}

TEST(MountMonitor, AnIntervalGoesOnWhereTheMapMoves) {
  MountMonitor still(kPriorSigma.cwiseAbs2().asDiagonal()), moved = still;
  Pose2 T_new_old;
  for (int i = 0; i < 20; ++i) {
    const Pose2 odometry{0.1 * i, 0.0, 0.0}, matched{0.1 * i, -0.007 * i, 0.0};
    still.compare(odometry, matched, true);
    moved.compare(odometry, T_new_old * matched, true);
    const Pose2 correction{0.02, -0.01, 0.003};
    moved.transform(correction);
    T_new_old = correction * T_new_old;
  }
  EXPECT_GT(still.error().mean.z(), 3.0 * kDegree);
  EXPECT_NEAR(moved.error().mean.z(), still.error().mean.z(), 1e-6);
}

TEST(MountMonitor, AMountsErrorActsSinceTheMapBeganAndMovesWithIt) {
  MountMonitor monitor(kPriorSigma.cwiseAbs2().asDiagonal());
  const Pose2 begin{3.0, -2.0, 0.4}, ahead = begin * Pose2{10.0, 0.0, 0.0}, turned = begin * Pose2{0.0, 0.0, 3.14159};
  monitor.beginMap(begin);
  EXPECT_LT(monitor.covarianceAt(begin).norm(), 1e-12);
  const Eigen::Matrix3d far = monitor.covarianceAt(ahead), back = monitor.covarianceAt(turned);
  EXPECT_NEAR(std::sqrt(far.topLeftCorner<2, 2>().trace()), 10.0 * 0.5 * kDegree, 1e-6);
  EXPECT_NEAR(std::sqrt(back.topLeftCorner<2, 2>().trace()), 2.0 * std::sqrt(2.0) * 0.01, 1e-4);
  const Pose2 T_new_old{1.0, 2.0, 0.3};
  monitor.transform(T_new_old);
  EXPECT_TRUE(monitor.covarianceAt(T_new_old * ahead).isApprox(rotated(far, 0.3), 1e-9));
}

TEST(MountMonitor, AnErrorThatIsLeftCountsWhole) {
  const MountError error{.mean = {0.0, 0.0, 0.1}, .covariance = 1e-4 * Eigen::Matrix3d::Identity()};
  EXPECT_NEAR(error.secondMoment()(2, 2), 0.0101, 1e-12);
  EXPECT_NEAR(error.secondMoment()(0, 0), 0.0001, 1e-12);
}

}  // namespace
}  // namespace slam::mount_monitor_test
