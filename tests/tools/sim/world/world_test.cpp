// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/world.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

namespace slam::sim::world_test {
namespace {

constexpr double kPi = std::numbers::pi;

World someWorld() {
  World world;
  world.add(Box{2.0, 0.0, kPi / 6, 1.0, 0.5, 0.2, 1.0});
  world.add(Cylinder{-1.5, 0.5, 0.3, 0.0, 0.8});
  world.add(Sphere{0.0, 2.0, 0.5, 0.4});
  return world;
}

TEST(World, ARayMeetsTheSameThingsInALargeWorldAsInAllOfThem) {
  World world;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-150.0, 150.0), size(0.5, 60.0), angle(-kPi, kPi);
  for (int i = 0; i < 150; ++i) world.add(Box{place(random), place(random), angle(random), size(random), 0.5});
  for (int i = 0; i < 50; ++i) world.add(Cylinder{place(random), place(random), 2.0, 0.0, 2.5});
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    const double bearing = angle(random), reach = i % 3 == 0 ? std::numeric_limits<double>::infinity() : size(random);
    const Eigen::Vector3d from(place(random), place(random), 0.2);
    const Eigen::Vector3d direction(std::cos(bearing), std::sin(bearing), 0.0);
    const double nearest = world.still().castRay(from, direction);
    const auto range = world.castRay(from, direction, reach);
    EXPECT_EQ(range.has_value(), nearest <= reach);
    if (range) {
      EXPECT_EQ(*range, nearest);
      hits += std::isfinite(nearest);
    }
  }
  EXPECT_GT(hits, 2000);
}

TEST(World, ARayEndsWhereSomethingStandsAndNowhereBefore) {
  const World world = someWorld();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-kPi, kPi), height(0.05, 1.2);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const double bearing = angle(random), z = height(random);
    const Eigen::Vector3d from(0.2, 0.3, z), direction(std::cos(bearing), std::sin(bearing), 0.0);
    const auto range = world.castRay(from, direction, 10.0);
    for (double r = 0.0; r < range.value_or(4.0) - 1e-3; r += 0.02) {
      ASSERT_FALSE(world.occupied((from + r * direction).head<2>(), z, z));
    }
    if (!range) continue;
    ++hits;
    EXPECT_TRUE(world.occupied((from + (*range + 1e-6) * direction).head<2>(), z, z, 1e-5));
  }
  EXPECT_GT(hits, 200);
}

TEST(World, ATableIsHollowBelowItsTop) {
  World world;
  world.add(Box{0.0, 0.0, 0.0, 1.0, 1.0, 0.70, 0.74});
  EXPECT_FALSE(world.castRay({-2, 0, 0.18}, {1, 0, 0}, 5.0));
  EXPECT_NEAR(world.castRay({-2, 0, 0.72}, {1, 0, 0}, 5.0).value(), 1.5, 1e-12);
  EXPECT_FALSE(world.occupied({0, 0}, 0.0, 0.5));
  EXPECT_TRUE(world.occupied({0, 0}, 0.0, 1.0));
}

TEST(World, SeesSlantedRaysInThreeDimensions) {
  World world;
  world.add(Sphere{3.0, 0.0, 1.0, 0.5});
  const Eigen::Vector3d direction = Eigen::Vector3d(3.0, 0.0, 1.0).normalized();
  EXPECT_NEAR(world.castRay({0, 0, 0}, direction, 10.0).value(), std::sqrt(10.0) - 0.5, 1e-12);
  EXPECT_FALSE(world.castRay({0, 0, 0}, direction, 2.0));  // out of reach
}

TEST(World, ABandCutsASphereAtItsWidestHeight) {
  World world;
  world.add(Sphere{0.0, 0.0, 0.5, 0.5});
  EXPECT_TRUE(world.occupied({0.49, 0.0}, 0.0, 1.0));
  EXPECT_FALSE(world.occupied({0.49, 0.0}, 0.0, 0.1));
  EXPECT_TRUE(world.occupied({0.25, 0.0}, 0.0, 0.1));
}

TEST(World, ShowsAPersonOnlyWhileItIsThereAndNeverAsLasting) {
  World world;
  world.add(Cylinder{9.0, 0.0, 0.1, 0.0, 2.0});
  world.add(Person{.path = {{3.0, -1.0}, {3.0, 1.0}}, .speed = 0.5, .begin = 5.0, .end = 9.0});
  const auto range = [&](double time) {
    world.setTime(time);
    return world.castRay({0.0, 0.0, 1.2}, {1.0, 0.0, 0.0}, 20.0).value();
  };
  EXPECT_NEAR(range(0.0), 8.9, 1e-12);
  EXPECT_NEAR(range(7.0), 2.8, 1e-12);  // the torso
  EXPECT_FALSE(world.occupied({3.0, 0.0}, 0.0, 2.0, 0.3));
  EXPECT_EQ(world.bounds().low.x(), 8.9);
  EXPECT_NEAR(range(9.0), 8.9, 1e-12);
}

TEST(World, CountsAMovedThingAtItsLastPlaceAndShowsItWhereItIs) {
  World world;
  world.add(MovedThing{
      .before = {.boxes = {{2.0, 0.0, 0.0, 1.0, 1.0}}}, .after = {.boxes = {{5.0, 0.0, 0.0, 1.0, 1.0}}}, .time = 30.0});
  const auto range = [&] { return world.castRay({0.0, 0.0, 0.5}, {1.0, 0.0, 0.0}, 20.0).value(); };
  EXPECT_NEAR(range(), 1.5, 1e-12);
  EXPECT_FALSE(world.occupied({2.0, 0.0}, 0.0, 1.0));
  EXPECT_TRUE(world.occupied({5.0, 0.0}, 0.0, 1.0));
  world.setTime(30.0);
  EXPECT_NEAR(range(), 4.5, 1e-12);
  EXPECT_NEAR(world.bounds().high.x(), 5.5, 1e-12);
}

TEST(World, OpensADoorAgain) {
  World world;
  world.add(MovedThing{.before = {}, .after = {.boxes = {{2.0, 0.0, 0.0, 1.0, 1.0}}}, .time = 10.0, .back = 20.0});
  const auto range = [&](double time) {
    world.setTime(time);
    return world.castRay({0.0, 0.0, 0.5}, {1.0, 0.0, 0.0}, 20.0);
  };
  EXPECT_FALSE(range(9.9));
  EXPECT_TRUE(range(10.0));
  EXPECT_TRUE(range(19.9));
  EXPECT_FALSE(range(20.0));
  EXPECT_FALSE(world.occupied({2.0, 0.0}, 0.0, 1.0)) << "what lasts is the open door";
}

}  // namespace
}  // namespace slam::sim::world_test
