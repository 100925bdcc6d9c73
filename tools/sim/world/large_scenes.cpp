// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <random>

#include "tools/sim/world/furniture.hpp"
#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {
namespace {

Waypoint passing(double x, double y) { return {.pose = {x, y, 0.0}, .stop = false, .pause = 0.0}; }

// Of the streets [m].
constexpr double kBlockLength = 24.0, kBlockDepth = 16.0, kStreet = 6.0;
constexpr double kDeepest = 0.8;                                                 // of a niche
constexpr double kAcross = kBlockLength + kStreet, kUp = kBlockDepth + kStreet;  // from crossing to crossing

/// Builds the blocks: a core, and before it fronts with niches.
class BlockBuilder {
 public:
  BlockBuilder(World& world, std::uint64_t seed) : world_(world), random_(seed) {}

  void add(double x, double y) {
    world_.add(Box{x, y, 0.0, kBlockLength - 2 * kDeepest, kBlockDepth - 2 * kDeepest});
    for (const double side : {-1.0, 1.0}) {
      front({x, y + side * (kBlockDepth - kDeepest) / 2}, {1, 0}, {0, side}, kBlockLength);
      front({x + side * (kBlockLength - kDeepest) / 2, y}, {0, 1}, {side, 0}, kBlockDepth - 2 * kDeepest);
    }
  }

 private:
  void front(const Eigen::Vector2d& middle, const Eigen::Vector2d& along, const Eigen::Vector2d& outward,
             double length) {
    const auto piece = [&](double begin, double end, double niche) {
      const Eigen::Vector2d centre = middle + ((begin + end) / 2 - length / 2) * along - niche / 2 * outward;
      world_.add(Box{centre.x(), centre.y(), std::atan2(along.y(), along.x()), end - begin, kDeepest - niche});
    };
    for (double begin = 0.0; begin < length;) {
      const double niche = begin + uniform(1.5, 6.0), end = niche + uniform(0.8, 2.5);
      if (end + 1.0 > length) return piece(begin, length, 0.0);
      piece(begin, niche, 0.0);
      piece(niche, end, uniform(0.2, 0.7));
      begin = end;
    }
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  World& world_;
  std::mt19937_64 random_;
};

/// From crossing to crossing of a grid, never back at once.
void wander(Scene& scene, std::uint64_t seed, int blocks) {
  std::mt19937_64 random(seed ^ 0x2545F4914F6CDD1DULL);
  Eigen::Vector2i at(0, 0), from(-1, -1);
  for (int i = 0; i < 3 * blocks * blocks / 2 + 1; ++i) {
    std::vector<Eigen::Vector2i> next;
    for (const Eigen::Vector2i& step :
         {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, -1)}) {
      const Eigen::Vector2i to = at + step;
      if (to.minCoeff() >= 0 && to.maxCoeff() <= blocks && to != from) next.push_back(to);
    }
    from = at;
    at = next[std::uniform_int_distribution<std::size_t>(0, next.size() - 1)(random)];
    scene.route.push_back(passing(at.x() * kAcross, at.y() * kUp));
  }
  scene.route.back().measured = true;
  scene.route.back().pause = 1.0;
}

}  // namespace

Scene hall(std::uint64_t seed) {
  Scene scene{.name = "hall", .speed = 0.5, .turn_rate = 45 * kDegree};
  constexpr double kLeft = -4.0, kBottom = -4.0, kLength = 40.0, kDepth = 30.0;
  addRoom(scene.world, kLeft, kBottom, kLeft + kLength, kBottom + kDepth);
  for (const double x : {6.0, 16.0, 26.0}) {
    for (const double y : {5.5, 16.5}) scene.world.add(Cylinder{x, y, 0.3, 0.0, 2.5});
  }
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> shift(-1.5, 1.5), length(2.0, 5.0), turn(-0.1, 0.1);
  const auto shelf = [&](double x, double y) {
    const double out = shift(random), along = shift(random);
    scene.world.add(Box{x + along, y + 0.3 * out, turn(random), length(random), 0.6, 0.0, 2.0});
  };
  shelf(11.0, 4.0);
  shelf(21.0, 7.5);
  shelf(10.0, 18.0);
  shelf(22.0, 15.0);
  shelf(4.0, -3.0);
  shelf(20.0, 25.0);
  scene.route = {passing(32, 0),
                 passing(32, 22),
                 passing(0, 22),
                 passing(0, 11),
                 passing(32, 11),
                 passing(32, 0),
                 {.pose = {0, 0, 0}, .measured = true}};
  return scene;
}

Scene bareCorridor(double length) {
  Scene scene{.name = "corridor-" + std::to_string(static_cast<int>(length)),
              .speed = length > 40.0 ? 0.5 : 0.4,
              .turn_rate = 45 * kDegree};
  addRoom(scene.world, -1.5, -1.0, length - 1.5, 1.0);
  scene.route = {{.pose = {length - 3.0, 0, kPi}, .measured = true}, {.pose = {0, 0, 0}, .measured = true}};
  return scene;
}

Scene streets(std::uint64_t seed, int blocks) {
  Scene scene{.name = "streets", .speed = 1.0, .turn_rate = 45 * kDegree};
  addRoom(scene.world, -kStreet / 2, -kStreet / 2, blocks * kAcross + kStreet / 2, blocks * kUp + kStreet / 2);
  BlockBuilder builder(scene.world, seed);
  for (int i = 0; i < blocks; ++i) {
    for (int j = 0; j < blocks; ++j) builder.add((i + 0.5) * kAcross, (j + 0.5) * kUp);
  }
  wander(scene, seed, blocks);
  return scene;
}

}  // namespace slam::sim
