// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/scenes.hpp"

#include <gtest/gtest.h>

#include "tools/sim/robot/simulation.hpp"

namespace slam::sim::scenes_test {
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

TEST(Scenes, EachOfTheEightHomesIsDrivenWithItsFurnitureMovedToo) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const int moved : {0, 1, 2}) {
      Scene scene = makeScene("homes", seed, {.furniture_moved = moved});
      Simulation simulation(scene, 1, Timestamp{});
      simulation.release();
      while (!simulation.finished() && simulation.driveTime() < 600.0) {
        for (int i = 0; i < 20; ++i) simulation.step();
        const Eigen::Vector2d robot = simulation.robot().pose().translation();
        ASSERT_FALSE(scene.world.occupied(robot, kFloorClearance, kRobotHeight, kRobotRadius))
            << "home " << seed << ", moved " << moved << " at " << robot.transpose();
      }
      EXPECT_TRUE(simulation.finished());
    }
  }
}

TEST(Scenes, FurnitureIsMovedByHalfAMetreToOneAndWallsAreNot) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Solids first = makeScene("homes", seed).world.still();
    const Solids moved = makeScene("homes", seed, {.furniture_moved = 1}).world.still();
    ASSERT_EQ(first.boxes.size(), moved.boxes.size());
    int shifted = 0, furniture = 0;
    for (std::size_t i = 0; i < first.boxes.size(); ++i) {
      const Box &a = first.boxes[i], &b = moved.boxes[i];
      const double way = std::hypot(a.x - b.x, a.y - b.y);
      furniture += a.top < 2.0;  // doors and walls are higher
      shifted += way > 0.0;
      if (way > 0.0) {
        EXPECT_GE(way, 0.499);
        EXPECT_LE(way, 1.001);
        EXPECT_LT(a.top, 2.0);
      }
    }
    EXPECT_GE(shifted, furniture / 2) << seed;
    EXPECT_GE(furniture, 4) << seed;
  }
}

TEST(Scenes, ThereAreEightHomes) {
  const auto walls = [](std::uint64_t seed) { return makeScene("homes", seed).world.bounds().high; };
  for (std::uint64_t a = 1; a <= 8; ++a) {
    EXPECT_EQ(walls(a), walls(a + 8));
    for (std::uint64_t b = a + 1; b <= 8; ++b) EXPECT_GT((walls(a) - walls(b)).norm(), 0.01) << a << " and " << b;
  }
}

TEST(Scenes, StreetsAreAsManyAsAskedAndTheirBlocksAlikeButForTheNiches) {
  const World world = makeScene("streets", 1, {.blocks = 24}).world;
  EXPECT_NEAR(world.bounds().high.x(), 24 * 30.0 + 3.0, 0.2);
  for (int i = 0; i < 24; ++i) {
    EXPECT_TRUE(world.occupied({15.0 + 30.0 * i, 11.0 + 22.0 * i}, 0.1, 0.3));  // a block
    EXPECT_FALSE(world.occupied({30.0 * i, 22.0 * i}, 0.1, 0.3, 2.9));          // a crossing
    EXPECT_FALSE(world.occupied({15.0 + 30.0 * i, 22.0 * i}, 0.1, 0.3, 2.89));  // a street
    EXPECT_TRUE(world.occupied({3.05 + 30.0 * i, 3.05 + 22.0 * i}, 0.1, 0.3));  // a block's corner
  }
}

TEST(Scenes, ARouteIsDrivenInLapsAndVariantsThatASceneHasNotAreRefused) {
  EXPECT_EQ(makeScene("home", 1, {.laps = 3}).route.size(), 3 * makeScene("home", 1).route.size());
  EXPECT_THROW(makeScene("office-floor", 1, {.laps = 2}), std::invalid_argument);
  EXPECT_THROW(makeScene("hall", 1, {.furniture_moved = 1}), std::invalid_argument);
  EXPECT_THROW(makeScene("hall", 1, {.floor = 1}), std::invalid_argument);
  EXPECT_THROW(makeScene("home", 1, {.lift = 1}), std::invalid_argument);
  EXPECT_THROW(makeScene("home", 1, {.blocks = 5}), std::invalid_argument);
}

/// In the homes' lift the robot is there before the door shuts, sees nothing of the floor while it rides, and comes out
/// on another one, with the same walls.
TEST(Scenes, ALiftTakesTheRobotToAnotherFloor) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Scene scene = makeScene("homes", seed, {.floor = 1, .lift = 2});
    const World below = makeScene("homes", seed, {.floor = 1, .lift = SceneVariant::kOpenLift}).world,
                above = makeScene("homes", seed, {.floor = 2, .lift = SceneVariant::kOpenLift}).world;
    Simulation simulation(scene, seed, Timestamp{});
    simulation.release();
    const auto blocked = [&] {  // from the cabin's middle to the corridor
      scene.world.setTime(simulation.driveTime());
      return !!scene.world.castRay({-1.55, 0.0, 0.1}, {1.0, 0.0, 0.0}, 3.0);
    };
    const auto sameAs = [&](const World& floor) {
      for (double x = -0.7; x < 8.0; x += 0.05) {
        for (double y = -6.0; y < 6.0; y += 0.05) {
          const Eigen::Vector2d p(x, y);
          const bool here =
              scene.world.still().occupied(p, 0.1, 0.3, 0.0) || scene.world.moving().occupied(p, 0.1, 0.3, 0.0);
          if (here != floor.occupied(p, 0.1, 0.3)) return false;
        }
      }
      return true;
    };
    EXPECT_FALSE(blocked());
    EXPECT_TRUE(sameAs(below));
    while (!blocked()) simulation.step();
    const double shut = simulation.driveTime();
    EXPECT_LT((simulation.robot().pose().translation() - Eigen::Vector2d(-1.55, 0.0)).norm(), 0.02) << seed;
    while (blocked()) {
      simulation.step();
      ASSERT_LT((simulation.robot().pose().translation() - Eigen::Vector2d(-1.55, 0.0)).norm(), 0.02) << seed;
    }
    EXPECT_NEAR(simulation.driveTime() - shut, 10.0, 0.1);
    EXPECT_TRUE(sameAs(above));
    while (simulation.visits().size() < 3) simulation.step();
    EXPECT_GT(simulation.driveTime() - shut, 13.0) << "its second visit of the cabin is its departure";
  }
}

TEST(Scenes, TheMeetingRoomsTopsAreAboveTheLidar) {
  const World world = makeScene("meeting-room", 1).world;
  EXPECT_TRUE(world.occupied({3.0, -3.0}, 0.71, 0.73));
  EXPECT_FALSE(world.occupied({3.0, -3.0}, 0.0, 0.69));
  EXPECT_TRUE(world.occupied({2.1, -4.35}, 0.44, 0.46));
}

}  // namespace
}  // namespace slam::sim::scenes_test
