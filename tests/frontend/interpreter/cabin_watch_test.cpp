// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/cabin_watch.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

#include "tools/sim/world/moving_things.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::test::cabin_watch_test {
namespace {

using namespace std::chrono_literals;
constexpr double kHeight = 0.18;  // [m] of the lidar
const RangeLimits kLimits{0.15F, 12.0F};

/// A cabin of 1.2 m by 1.5 m behind a corridor's end, with a door of 0.9 m.
struct Building {
  explicit Building(double shuts = 1e9, double opens = 1e9) {
    world.addWall({-0.8, 0.6}, {-2.3, 0.6});
    world.addWall({-2.3, 0.6}, {-2.3, -0.6});
    world.addWall({-2.3, -0.6}, {-0.8, -0.6});
    for (const double side : {-1.0, 1.0}) {
      world.addWall({-0.8, 0.45 * side}, {-0.8, 0.8 * side});
      world.addWall({-0.8, 0.8 * side}, {9.0, 0.8 * side});
    }
    world.addWall({9.0, -0.8}, {9.0, 0.8});
    sim::Solids door;
    door.boxes.push_back({-0.8, 0.0, 0.0, 0.06, 0.9, 0.0, 2.5});
    world.add(sim::MovedThing{.before = {}, .after = door, .time = shuts, .back = opens});
  }
  sim::World world;
};

/// A robot with a lidar of ten turns a second.
class Robot {
 public:
  Robot(sim::World& world, unsigned seed, double field = 2.0 * std::numbers::pi)
      : world_(world), random_(seed), field_(field) {}

  /// @return times that it may have left a cabin
  int stand(const Pose2& at, double seconds) {
    int opened = 0;
    for (const double end = time_ + seconds; time_ < end; time_ += 0.1) {
      world_.setTime(time_);
      look(at);
      watch_.add(beams_, kLimits, at, Timestamp(fromSeconds(time_)));
      opened += watch_.opened();
    }
    return opened;
  }
  double area() const { return watch_.viewOf(beams_, kLimits).area; }

 private:
  void look(const Pose2& at) {
    constexpr int kBeams = 360;
    beams_.clear();
    std::normal_distribution<double> noise(0.0, 0.01);
    std::bernoulli_distribution missed(0.02);
    for (int i = 0; i < kBeams; ++i) {
      const double bearing = wrapAngle(-field_ * i / kBeams + field_ / 2), direction = at.theta + bearing;
      const auto range = world_.castRay({at.x, at.y, kHeight}, {std::cos(direction), std::sin(direction), 0.0}, 12.0);
      const double seen = range && !missed(random_) ? *range + noise(random_) : 0.0;
      beams_.push_back({.range = static_cast<float>(seen), .bearing = static_cast<float>(bearing)});
    }
  }

  sim::World& world_;
  std::mt19937 random_;
  double field_, time_ = 0.0;
  CabinWatch watch_;
  std::vector<Beam> beams_;
};

TEST(CabinWatch, NoticesALiftWhereverInTheCabinTheRobotStandsAndTurns) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> x(-1.9, -1.2), y(-0.25, 0.25), heading(-3.1, 3.1);
    Building building(5.0, 15.0);
    Robot robot(building.world, seed);
    const Pose2 at{x(random), y(random), heading(random)};
    EXPECT_EQ(robot.stand(at, 8.0), 0) << seed;
    EXPECT_NEAR(robot.area(), 1.6, 0.3) << "the inside of the cabin";
    EXPECT_EQ(robot.stand({at.x, at.y, heading(random)}, 6.9), 0) << seed;
    EXPECT_EQ(robot.stand({at.x, at.y, heading(random)}, 5.0), 1) << "the door opens, once";
    EXPECT_EQ(robot.stand({0.5, 0.0, 0.0}, 10.0), 0);
  }
}

TEST(CabinWatch, TakesAMomentBehindADoorForNoLift) {
  Building building(5.0, 7.5);
  Robot robot(building.world, 1);
  EXPECT_EQ(robot.stand({-1.5, 0.0, 0.0}, 20.0), 0);
}

TEST(CabinWatch, TakesALookIntoTheCabinForNoLift) {
  Building building;
  Robot robot(building.world, 1);
  for (double x = 0.5; x > -1.6; x -= 0.02) EXPECT_EQ(robot.stand({x, 0.0, 3.1}, 0.1), 0) << x;
  EXPECT_EQ(robot.stand({-1.6, 0.0, 3.1}, 10.0), 0);
  for (double x = -1.6; x < 0.5; x += 0.02) EXPECT_EQ(robot.stand({x, 0.0, 0.0}, 0.1), 0) << x;
}

TEST(CabinWatch, TakesPeopleAroundARobotThatStandsForNoLift) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> along(-1.0, 1.0), across(-0.6, 0.6), speed(0.1, 0.9);
    Building building;
    for (int i = 0; i < 6; ++i) {
      const double side = i % 2 == 0 ? 0.35 : -0.35;
      building.world.add(sim::Person{.path = {{3.0 + along(random), side}, {4.0 + along(random) + 1.2, side + 0.1}},
                                     .speed = speed(random),
                                     .begin = 0.0,
                                     .end = 60.0});
    }
    Robot robot(building.world, seed);
    EXPECT_EQ(robot.stand({3.5, 0.0, along(random)}, 60.0), 0) << seed;
  }
}

/// The door of a room of 4 m by 4 m shuts and opens.
TEST(CabinWatch, TakesTheDoorOfARoomForNoLift) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1.3, 1.3);
    sim::World world;
    world.addWall({-2.0, -2.0}, {-2.0, 2.0});
    world.addWall({-2.0, 2.0}, {2.0, 2.0});
    world.addWall({2.0, 2.0}, {2.0, -2.0});
    world.addWall({2.0, -2.0}, {0.45, -2.0});
    world.addWall({-0.45, -2.0}, {-2.0, -2.0});
    world.addWall({-6.0, -3.5}, {6.0, -3.5});
    sim::Solids door;
    door.boxes.push_back({0.0, -2.0, 0.0, 0.9, 0.06, 0.0, 2.5});
    world.add(sim::MovedThing{.before = {}, .after = door, .time = 5.0, .back = 15.0});
    Robot robot(world, seed);
    EXPECT_EQ(robot.stand({place(random), place(random), place(random)}, 25.0), 0) << seed;
  }
}

TEST(CabinWatch, TakesATurnOfALidarThatLooksAheadForNoLift) {
  Building building;
  Robot robot(building.world, 1, std::numbers::pi);
  for (const double heading : {0.0, 1.57, 0.0, 3.1, 1.57, 0.0}) EXPECT_EQ(robot.stand({3.5, 0.5, heading}, 6.0), 0);
}

TEST(CabinWatch, ReportsNothingWhereLittleComesBack) {
  CabinWatch watch;
  std::vector<Beam> beams(360);
  for (std::size_t i = 0; i < beams.size(); ++i) beams[i].bearing = static_cast<float>(0.0174 * static_cast<double>(i));
  for (int i = 0; i < 300; ++i) {
    const double range = i > 100 && i < 200 ? 0.5 : 5.0;
    for (std::size_t k = 0; k < beams.size(); ++k)
      beams[k].range = k % 10 < 7 && k < 200 ? static_cast<float>(range) : 0.0F;
    watch.add(beams, kLimits, {}, Timestamp(fromSeconds(0.1 * i)));
    ASSERT_FALSE(watch.opened()) << i;
  }
  watch.add({}, kLimits, {}, Timestamp(fromSeconds(40.0)));
  EXPECT_FALSE(watch.opened());
}

}  // namespace
}  // namespace slam::test::cabin_watch_test
