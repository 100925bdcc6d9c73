// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/scenes.hpp"

#include <gtest/gtest.h>

#include "tools/sim/robot/simulation.hpp"

namespace slam::sim {
namespace {

constexpr double kRobotRadius = 0.2, kRobotHeight = 0.8, kFloorClearance = 0.05;  // [m]

class AnyScene : public testing::TestWithParam<std::string> {};

TEST_P(AnyScene, IsDrivenToItsEndWithoutTouchingAnything) {
  Scene scene = makeScene(GetParam(), 1);
  Simulation simulation(scene, 1, Timestamp{});
  simulation.release();
  EXPECT_EQ(simulation.robot().pose(), Pose2{});
  double last_person = 0.0;
  for (const Person& person : scene.world.persons()) last_person = std::max(last_person, person.end);
  while (!simulation.finished() && simulation.driveTime() < 1200.0) {
    for (int i = 0; i < 20; ++i) simulation.step();
    const Eigen::Vector2d robot = simulation.robot().pose().translation();
    scene.world.setTime(simulation.driveTime());
    ASSERT_FALSE(scene.world.occupied(robot, kFloorClearance, kRobotHeight, kRobotRadius)) << robot.transpose();
    ASSERT_FALSE(scene.world.moving().occupied(robot, kFloorClearance, kRobotHeight, kRobotRadius + 0.1))
        << robot.transpose() << " at " << simulation.driveTime() << " s";
  }
  EXPECT_TRUE(simulation.finished());
  RecordProperty("seconds", std::to_string(simulation.driveTime()));
  if (last_person > 0.0) {
    EXPECT_GT(simulation.driveTime(), last_person + 30.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, AnyScene, testing::ValuesIn(sceneNames()), [](const auto& test) {
  std::string name = test.param;
  std::erase(name, '-');
  return name;
});

TEST(Scenes, AnUnknownNameIsRefusedWithTheKnownOnes) {
  EXPECT_THROW(
      {
        try {
          makeScene("attic", 1);
        } catch (const std::invalid_argument& error) {
          for (const std::string& name : sceneNames()) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
          }
          throw;
        }
      },
      std::invalid_argument);
}

TEST(Scenes, TheMeetingRoomsTopsAreAboveTheLidar) {
  const World world = makeScene("meeting-room", 1).world;
  EXPECT_TRUE(world.occupied({3.0, -3.0}, 0.71, 0.73));
  EXPECT_FALSE(world.occupied({3.0, -3.0}, 0.0, 0.69));
  EXPECT_TRUE(world.occupied({2.1, -4.35}, 0.44, 0.46));
}

}  // namespace
}  // namespace slam::sim
