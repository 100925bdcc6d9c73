// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <random>

#include "tools/sim/world/furniture.hpp"
#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;

}  // namespace

Scene tileRectangle() {
  Scene scene{.name = "tile-rectangle"};
  addRoom(scene.world, -1.5, -4.6, 3.2, 1.2);
  scene.world.add(Box{2.6, 0.7, 0.0, 0.9, 0.6, 0.0, 1.2});
  scene.world.add(Box{-1.1, -3.4, 0.0, 0.5, 1.4, 0.0, 0.9});
  scene.world.add(Cylinder{2.7, -3.6, 0.2, 0.0, 1.0});
  scene.route = {{.pose = {1.3, 0.0, -kPi / 2}, .measured = true},
                 {.pose = {1.3, -3.25, -kPi}, .measured = true},
                 {.pose = {0.0, -3.25, kPi / 2}, .measured = true},
                 {.pose = {0.0, 0.0, 0.0}}};
  return scene;
}

Scene meetingRoom() {
  Scene scene{.name = "meeting-room"};
  addRoom(scene.world, -1.6, -6.8, 7.6, 0.9);
  for (const double x : {1.6, 3.0, 4.4}) addTable(scene.world, x, -3.0, 1.35, 1.6);
  for (const double x : {1.3, 2.1, 3.3, 4.6}) scene.world.add(chair(x, -4.35));
  for (const double x : {1.8, 3.1, 4.2}) scene.world.add(chair(x, -1.65));
  scene.world.add(Box{-1.25, -2.6, 0.0, 0.5, 1.8, 0.0, 1.9});  // cupboard
  scene.world.add(Box{7.25, -1.6, 0.0, 0.5, 1.1, 0.0, 1.2});   // sideboard
  scene.world.add(Box{2.4, 0.62, 0.0, 2.2, 0.4, 0.0, 0.8});    // radiator
  scene.world.add(Box{5.6, -6.5, 0.35, 0.6, 0.4, 0.0, 0.7});   // crate, put down askew
  scene.world.add(Cylinder{-1.1, 0.4, 0.22, 0.0, 1.1});        // plant
  scene.world.add(Cylinder{7.2, -6.3, 0.18, 0.0, 0.6});        // bin
  scene.world.add(Cylinder{0.6, -5.0, 0.12, 0.0, 2.5});        // pillar
  scene.route = {{.pose = {6.0, 0.0, -30 * kDegree}, .measured = true},
                 {.pose = {6.0, -3.0, -90 * kDegree}, .measured = true},
                 {.pose = {6.0, -6.0, -90 * kDegree}, .measured = true},
                 {.pose = {0.0, -6.0, -180 * kDegree}, .measured = true},
                 {.pose = {0.0, 0.0, 0.0}, .measured = true}};
  return scene;
}

Scene corridorLoop(std::uint64_t seed) {
  Scene scene{.name = "corridor-loop", .speed = 0.5, .turn_rate = 45 * kDegree};
  constexpr double kLength = 41.0, kDepth = 21.0, kHalf = 1.0;
  addRoom(scene.world, -kHalf, -kDepth - kHalf, kLength + kHalf, kHalf);
  addRoom(scene.world, kHalf, -kDepth + kHalf, kLength - kHalf, -kHalf);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> gap(2.5, 6.0), depth(0.08, 0.2), width(0.2, 0.9);
  const auto side = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& along, double length,
                        const Eigen::Vector2d& inward) {
    for (double at = gap(random); at < length - 1.5; at += gap(random)) {
      const double out = depth(random), wide = width(random);
      const Eigen::Vector2d centre = from + at * along + (out / 2) * inward;
      scene.world.add(Box{centre.x(), centre.y(), std::atan2(along.y(), along.x()), wide, out, 0.0, 2.5});
    }
  };
  side({0, kHalf}, {1, 0}, kLength, {0, -1});
  side({kLength + kHalf, 0}, {0, -1}, kDepth, {-1, 0});
  side({kLength, -kDepth - kHalf}, {-1, 0}, kLength, {0, 1});
  side({-kHalf, -kDepth}, {0, 1}, kDepth, {1, 0});
  side({1.5, -kHalf}, {1, 0}, kLength - 3.0, {0, 1});
  side({kLength - 1.5, -kDepth + kHalf}, {-1, 0}, kLength - 3.0, {0, -1});
  scene.route = {{.pose = {kLength, 0, 0}, .stop = false, .pause = 0.0},
                 {.pose = {kLength, -kDepth, 0}, .stop = false, .pause = 0.0},
                 {.pose = {0, -kDepth, 0}, .stop = false, .pause = 0.0},
                 {.pose = {0, 0, 0}, .stop = true, .measured = true},
                 {.pose = {4, 0, 0}, .stop = true, .measured = true}};
  return scene;
}

}  // namespace slam::sim
