// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include "tools/sim/world/furniture.hpp"
#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {
Scene gazebo() {
  Scene scene{.name = "gazebo", .speed = 0.3};
  World& world = scene.world;
  addRoom(world, -1.6, -7.2, 8.6, 1.0);
  addTable(world, 1.6, -1.5, 1.4, 0.7);
  addColumnTable(world, 3.6, -1.5, 0.9, 0.9);
  world.add(Sphere{5.3, -1.45, 0.35, 0.35});
  addTruck(world, 1.9, -4.6, 0.15);
  world.add(Sphere{3.7, -4.4, 0.25, 0.25});
  addTable(world, 4.9, -4.6, 0.7, 1.4);
  addColumnTable(world, 6.1, -4.5, 0.8, 0.8);
  world.add(Box{8.25, -3.2, 0.0, 0.5, 1.2, 0.0, 1.8});   // cupboard
  world.add(Box{-1.35, -1.6, 0.0, 0.3, 1.0, 0.0, 0.9});  // shelf
  world.add(Cylinder{-1.2, -6.8, 0.2, 0.0, 1.0});        // plant
  world.add(Sphere{8.0, 0.4, 0.3, 0.3});
  scene.route = {{.pose = {7.2, 0.0, -kPi / 2}, .measured = true}, {.pose = {7.2, -6.2, -kPi}, .measured = true},
                 {.pose = {0.0, -6.2, kPi / 2}, .measured = true}, {.pose = {0.0, -3.0, 0.0}, .measured = true},
                 {.pose = {7.2, -3.0, kPi / 2}, .measured = true}, {.pose = {7.2, 0.0, -kPi}},
                 {.pose = {0.0, 0.0, 0.0}, .measured = true}};
  return scene;
}

Scene people() {
  Scene scene{.name = "people", .speed = 0.3};
  World& world = scene.world;
  addRoom(world, -1.2, -5.4, 6.4, 1.4);
  addTable(world, 2.4, -2.2, 1.6, 0.8);
  world.add(chair(2.0, -1.35));
  world.add(chair(2.8, -3.05));
  world.add(Box{-0.95, -2.6, 0.0, 0.4, 1.6, 0.0, 1.8});  // cupboard
  world.add(Box{6.15, -2.0, 0.0, 0.4, 1.4, 0.0, 1.1});   // sideboard
  world.add(Cylinder{6.1, 1.1, 0.2, 0.0, 1.2});          // plant
  world.add(Box{3.4, -5.15, 0.2, 0.5, 0.35, 0.0, 0.6});  // crate
  world.add(Person{.path = {{2.4, -0.9}, {2.6, 1.1}}, .speed = 0.7, .begin = 3.0, .end = 23.0});
  world.add(Person{.path = {{3.6, 1.1}, {3.5, -0.8}, {4.4, -1.2}}, .speed = 0.9, .begin = 6.0, .end = 26.0});
  world.add(Person{.path = {{0.6, -4.9}, {1.4, -3.5}, {2.0, -4.9}}, .speed = 0.8, .begin = 62.0, .end = 82.0});
  world.add(MovedThing{.before = chair(4.0, 0.9), .after = chair(4.6, -3.0), .time = 80.0});
  scene.route = {{.pose = {0.3, 0.0, 0.0}, .pause = 24.0},
                 {.pose = {5.2, 0.0, -kPi / 2}, .measured = true},
                 {.pose = {5.2, -4.2, kPi}, .pause = 24.0, .measured = true},
                 {.pose = {0.0, -4.2, 0.0}, .pause = 2.0, .measured = true},
                 {.pose = {0.0, 0.0, 0.0}, .pause = 2.0, .measured = true},
                 {.pose = {5.2, 0.0, -kPi / 2}, .measured = true},
                 {.pose = {5.2, -4.2, kPi}, .pause = 2.0, .measured = true},
                 {.pose = {3.9, -4.2, kPi}, .measured = true}};
  return scene;
}

Scene openDoor() {
  Scene scene{.name = "open-door", .speed = 0.3};
  World& world = scene.world;
  constexpr double kWall = 3.0, kDoorPost = 0.53;  // [m] half a doorway of 0.96 m, and half a wall
  addRoom(world, -1.4, -2.4, 8.0, 1.8);
  world.addWall({kWall, -2.4}, {kWall, -kDoorPost});
  world.addWall({kWall, kDoorPost}, {kWall, 1.8});
  // The leaf hangs at the left post and stands open by 115 degrees, in the second room.
  constexpr double kLeaf = 0.94, kAngle = 25.0 * kPi / 180.0, kHinge = 0.50;  // [m, rad, m]
  world.add(Box{kWall + 0.07 + 0.5 * kLeaf * std::cos(kAngle), kHinge + 0.5 * kLeaf * std::sin(kAngle), kAngle, kLeaf,
                0.04, 0.01, 2.0});
  world.add(Box{1.0, 1.5, 0.0, 1.6, 0.4, 0.0, 0.9});  // sideboard
  world.add(Cylinder{-1.0, -2.0, 0.2, 0.0, 1.1});     // plant
  addTable(world, 1.2, -1.7, 1.2, 0.7);
  addTable(world, 6.9, -1.6, 0.8, 1.2);
  world.add(chair(6.2, -1.6));
  world.add(Box{5.6, 1.45, 0.0, 1.0, 0.5, 0.0, 1.8});  // cupboard
  world.add(Box{7.75, 0.8, 0.0, 0.3, 1.2, 0.0, 1.2});  // shelf
  scene.route = {{.pose = {2.0, 0.0, 0.0}},
                 {.pose = {6.4, 0.0, -kPi / 2}, .measured = true},
                 {.pose = {5.0, -1.4, kPi}, .measured = true},
                 {.pose = {4.4, 0.0, kPi}},
                 {.pose = {0.0, 0.0, kPi}, .measured = true},
                 {.pose = {0.0, 0.0, 0.0}, .measured = true}};
  return scene;
}

}  // namespace slam::sim
