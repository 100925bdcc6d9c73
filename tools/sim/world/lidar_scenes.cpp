// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "tools/sim/world/furniture.hpp"
#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {
namespace {

/// Builds the wall of a corridor, office by office.
class OfficeFront {
 public:
  OfficeFront(World& world, std::uint64_t seed) : world_(world), random_(seed) {}

  /// @param outward unit vector away from the corridor
  void add(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Eigen::Vector2d& outward) {
    from_ = from;
    along_ = (to - from).normalized();
    outward_ = outward;
    const double length = (to - from).norm();
    for (double begin = 0.0; begin < length;) {
      const double end = std::min(length, begin + uniform(3.0, 7.0));
      if (end - begin < kDoor + 1.0) {
        wall(begin, 0.0, end, 0.0);
      } else {
        addOffice(begin, end);
      }
      begin = end;
    }
  }

 private:
  static constexpr double kDoor = 0.95;  // [m]

  void addOffice(double begin, double end) {
    const double door = uniform(begin + 0.4, end - kDoor - 0.4);
    wall(begin, 0.0, door, 0.0);
    wall(door + kDoor, 0.0, end, 0.0);
    if (uniform(0.0, 1.0) > 1.0 / 3.0) {  // closed: its leaf stands back
      const double back = uniform(0.05, 0.15);
      wall(door, back, door + kDoor, back);
      return;
    }
    const double deep = uniform(3.0, 6.0);
    wall(begin + 0.1, 0.1, begin + 0.1, deep);
    wall(end - 0.1, 0.1, end - 0.1, deep);
    wall(begin + 0.1, deep, end - 0.1, deep);
    const Eigen::Vector2d desk = at(uniform(begin + 0.8, end - 0.8), uniform(1.2, deep - 0.6));
    world_.add(Box{desk.x(), desk.y(), uniform(0.0, kPi), uniform(0.3, 1.4), uniform(0.3, 0.8), 0.0, 0.75});
  }

  Eigen::Vector2d at(double s, double out) const { return from_ + s * along_ + out * outward_; }
  void wall(double s0, double out0, double s1, double out1) { world_.addWall(at(s0, out0), at(s1, out1)); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  World& world_;
  std::mt19937_64 random_;
  Eigen::Vector2d from_, along_, outward_;
};

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

Scene officeFloor(std::uint64_t seed) {
  Scene scene{.name = "office-floor", .speed = 0.5, .turn_rate = 45 * kDegree};
  constexpr double kLength = 80.0, kDepth = 40.0, kBetween = 30.0, kHalf = 1.2;
  OfficeFront front(scene.world, seed);
  front.add({-kHalf, kHalf}, {kLength + kHalf, kHalf}, {0, 1});
  front.add({kLength + kHalf, kHalf}, {kLength + kHalf, -kDepth - kHalf}, {1, 0});
  front.add({kLength + kHalf, -kDepth - kHalf}, {-kHalf, -kDepth - kHalf}, {0, -1});
  front.add({-kHalf, -kDepth - kHalf}, {-kHalf, kHalf}, {-1, 0});
  for (const auto& [west, east] : {std::pair{0.0, kBetween}, std::pair{kBetween, kLength}}) {
    front.add({west + kHalf, -kHalf}, {east - kHalf, -kHalf}, {0, -1});
    front.add({east - kHalf, -kHalf}, {east - kHalf, -kDepth + kHalf}, {-1, 0});
    front.add({east - kHalf, -kDepth + kHalf}, {west + kHalf, -kDepth + kHalf}, {0, 1});
    front.add({west + kHalf, -kDepth + kHalf}, {west + kHalf, -kHalf}, {1, 0});
  }
  const auto pass = [&](double x, double y) {
    scene.route.push_back({.pose = {x, y, 0}, .stop = false, .pause = 0.0});
  };
  pass(kLength, 0);
  pass(kLength, -kDepth);
  pass(0, -kDepth);
  pass(0, 0);
  pass(kBetween, 0);
  pass(kBetween, -kDepth);
  pass(0, -kDepth);
  scene.route.push_back({.pose = {0, -kDepth / 2, kPi / 2}, .stop = true, .measured = true});
  return scene;
}

}  // namespace slam::sim
