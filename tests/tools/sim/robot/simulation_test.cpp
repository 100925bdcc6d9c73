// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/robot/simulation.hpp"

#include <gtest/gtest.h>

namespace slam::sim::simulation_test {
namespace {

TEST(Simulation, ACarriedRobotComesToItsPlaceWithStillWheelsAndDrivesOnFromThere) {
  Scene scene = makeScene("home", 1);
  Simulation simulation(scene, 1, Timestamp{});
  simulation.release();
  while (simulation.driveTime() < 20.0) simulation.step();
  const auto wheels = simulation.robot().encoderAngles();
  const std::size_t place = scene.route.size() - 5;
  simulation.carryTo(place, 2.0, 3.0);
  double turned = 0.0, largest_step = 0.0;
  const double before = simulation.robot().pose().theta;
  while (simulation.carried()) {
    const Pose2 from = simulation.robot().pose();
    simulation.step();
    largest_step = std::max(largest_step, (simulation.robot().pose().translation() - from.translation()).norm());
    turned += simulation.robot().twist().omega * toSeconds(Simulation::kStep);
  }
  EXPECT_NEAR(simulation.driveTime(), 23.0, 0.01);
  EXPECT_LT(largest_step, 0.05);
  EXPECT_NEAR(turned, wrapAngle(2.0 - before), 1e-6);  // as a gyro feels it
  EXPECT_EQ(simulation.robot().encoderAngles(), wheels);
  const Pose2 put_down = simulation.robot().pose();
  EXPECT_NEAR((put_down.translation() - scene.route[place].pose.translation()).norm(), 0.0, 1e-9);
  EXPECT_NEAR(put_down.theta, 2.0, 1e-9);
  for (int i = 0; i < 180; ++i) simulation.step();
  EXPECT_EQ(simulation.robot().pose(), put_down);  // stands for a second
  while (!simulation.finished() && simulation.driveTime() < 200.0) {
    simulation.step();
    ASSERT_FALSE(scene.world.occupied(simulation.robot().pose().translation(), 0.05, 0.8, 0.2));
  }
  EXPECT_TRUE(simulation.finished());
}

TEST(Simulation, TheMotorsStallWhereSomethingIsInTheWay) {
  const Scene scene = makeScene("meeting-room", 1);
  Simulation simulation(scene, 1, Timestamp{});
  const auto drive = [&](const Twist2& twist, double seconds) {
    simulation.obey(twist);
    for (double t = 0.0; t < seconds; t += toSeconds(Simulation::kStep)) simulation.step();
    return simulation.robot().pose();
  };
  drive({.omega = 0.8}, 2.0);
  drive({.vx = 0.3}, 20.0);
  const auto wheels = simulation.robot().encoderAngles();
  const Pose2 stuck = drive({.vx = 0.3}, 2.0);
  EXPECT_FALSE(scene.world.occupied(stuck.translation(), 0.05, 0.3, 0.1));
  EXPECT_GT(stuck.y, 0.5) << "the wall is 0.9 m away";
  EXPECT_EQ(simulation.robot().encoderAngles(), wheels);
  const Pose2 freed = drive({.vx = -0.3}, 1.0);
  EXPECT_GT((freed.translation() - stuck.translation()).norm(), 0.2);
}

}  // namespace
}  // namespace slam::sim::simulation_test
