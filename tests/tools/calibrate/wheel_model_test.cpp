// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/wheel_model.hpp"

#include <gtest/gtest.h>
#include <numbers>

#include "tools/calibrate/motions.hpp"

namespace slam::wheel_model_test {
namespace {

TEST(WheelModel, DerivativesMeetDifferences) {
  constexpr double kDelta = 1e-6;
  const std::vector<WheelStep> wheels{{1.0, 2.0}, {2.5, 1.5}, {3.0, -1.0}, {0.0, 0.0}};
  const PredictedMotion predicted = predictMotion(test::kRobot, wheels);
  EXPECT_TRUE(predicted.T_begin_end.vector().isApprox(predictPose(test::kRobot, wheels).vector(), 1e-12));
  for (int i = 0; i < 6; ++i) {
    const RobotGeometry::Vector step = kDelta * RobotGeometry::Vector::Unit(i);
    const auto at = [&](double sign) {
      return predictPose(RobotGeometry::fromVector(test::kRobot.vector() + sign * step), wheels).vector();
    };
    const Eigen::Vector3d difference = (at(1.0) - at(-1.0)) / (2.0 * kDelta);
    EXPECT_TRUE(predicted.jacobian.col(i).isApprox(difference, 1e-6)) << "parameter " << i;
  }
}

TEST(WheelModel, TurningOnTheSpotMovesALidarThatIsOffTheCentre) {
  constexpr double kQuarter = std::numbers::pi / 2.0;
  const RobotGeometry robot{.left_radius = 0.1, .right_radius = 0.1, .track = 0.4, .T_base_lidar = {0.3, 0.0, 0.0}};
  const std::vector<WheelStep> wheels(10, {-0.2 * kQuarter, 0.2 * kQuarter});
  const Pose2 motion = predictPose(robot, wheels);
  EXPECT_NEAR(motion.x, -0.3, 1e-12);  // from ahead of the centre to its left
  EXPECT_NEAR(motion.y, 0.3, 1e-12);
  EXPECT_NEAR(motion.theta, kQuarter, 1e-12);
}

TEST(WheelModel, VectorHoldsAllParameters) {
  const RobotGeometry again = RobotGeometry::fromVector(test::kRobot.vector());
  EXPECT_EQ(again.vector(), test::kRobot.vector());
  EXPECT_EQ(again.T_base_lidar, test::kRobot.T_base_lidar);
}

}  // namespace
}  // namespace slam::wheel_model_test
