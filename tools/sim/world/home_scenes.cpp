// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "tools/sim/world/furniture.hpp"
#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {
namespace {

constexpr double kStart = 0.8;       // [m] from the corridor's end to the origin
constexpr double kDoor = 0.9;        // [m]
constexpr double kClearance = 0.40;  // [m] from the route's middle to furniture
constexpr int kHomes = 8;

/// A lift for 8 persons behind the corridor's end.
struct Lift {
  static constexpr double kDepth = 1.5, kWidth = 1.2;  // [m] of the cabin
  static constexpr double kWait = 3.0;                 // [s] with open doors, at least, before and after
  static constexpr double kRide = 10.0;                // [s] with closed doors
  static constexpr double kHurry = 12.0;  // [s] by which the robot may be there earlier than is reckoned with
};

struct HomePlan {
  double corridor = 1.3;                                   // [m] wide
  double below = 3.3, above = 3.4;                         // [m] depth of the rooms on either side
  std::vector<double> rooms_below = {}, rooms_above = {};  // [m] width of each
};

struct Item {
  Solids solids = {};
  Eigen::Vector2d centre;
  double radius = 0.0;  // [m] around all of it
};

/// Builds a home along a corridor that goes east from the origin.
class HomeBuilder {
 public:
  HomeBuilder(Scene& scene, const HomePlan& plan, std::uint64_t seed, const SceneVariant& variant)
      : scene_(scene),
        half_(plan.corridor / 2),
        random_(seed),
        moves_(seed * 7919 + static_cast<std::uint64_t>(variant.furniture_moved)),
        moved_(variant.furniture_moved != 0) {
    const double length = std::accumulate(plan.rooms_above.begin(), plan.rooms_above.end(), 0.0);
    const double bottom = -half_ - plan.below, top = half_ + plan.above;
    variant.lift ? addRoomWithDoor(length - kStart, bottom, top)
                 : addRoom(scene.world, -kStart, bottom, length - kStart, top);
    addSide(plan.rooms_above, plan.above, 1.0);
    addSide(plan.rooms_below, plan.below, -1.0);
    addRoute();
    const Solids furniture = furnitureOf(seed, variant.floor);
    const int upstairs = variant.lift.value_or(SceneVariant::kOpenLift);
    if (upstairs == SceneVariant::kOpenLift) {
      scene.world.add(furniture);
      if (variant.lift) addLift(0, Lift::kWait);
    } else {
      const double ride = takeLift();
      scene.world.add(MovedThing{.before = furniture, .after = furnitureOf(seed, upstairs), .time = ride});
    }
  }

 private:
  struct Room {
    double left, right, side, depth;  // [m]; side: 1 north of the corridor, -1 south of it
    double door;                      // [m] x of its middle

    double middle() const { return (left + right) / 2; }
  };

  /// Four walls around the home, with the lift's door in the one at the corridor's end, and the cabin behind it.
  void addRoomWithDoor(double right, double bottom, double top) {
    World& world = scene_.world;
    const double back = -kStart - Lift::kDepth, side = Lift::kWidth / 2;
    world.addWall({-kStart, bottom}, {right, bottom});
    world.addWall({right, bottom}, {right, top});
    world.addWall({right, top}, {-kStart, top});
    world.addWall({-kStart, top}, {-kStart, kDoor / 2});
    world.addWall({-kStart, -kDoor / 2}, {-kStart, bottom});
    world.addWall({-kStart, side}, {back, side});
    world.addWall({back, side}, {back, -side});
    world.addWall({back, -side}, {-kStart, -side});
  }

  /// The robot drives into the cabin, turns to the door and stands there.
  /// @param at waypoint of the route before which it does
  void addLift(std::size_t at, double pause) {
    const Pose2 cabin{-kStart - Lift::kDepth / 2, 0.0, 0.0};
    scene_.route.insert(
        scene_.route.begin() + static_cast<std::ptrdiff_t>(at),
        {{.pose = cabin, .pause = pause, .measured = true}, {.pose = cabin, .pause = 0.0, .measured = true}});
  }

  /// It visits the first room, takes the lift, and makes the whole round then. Its second visit of the cabin is its
  /// departure. @return [s] since the drive began, of the ride
  double takeLift() {
    constexpr std::size_t kVisit = 5;  // waypoints of a room
    const std::vector<Waypoint> round = scene_.route;
    scene_.route.insert(scene_.route.begin(), round.begin(), round.begin() + kVisit);
    addLift(kVisit, 2.0 * Lift::kWait + Lift::kRide + Lift::kHurry);
    const double close = latestArrival(kVisit) + Lift::kWait, open = close + Lift::kRide;
    Solids door;
    door.boxes.push_back({-kStart, 0.0, 0.0, 0.06, kDoor, 0.0, World::kCeiling});
    scene_.world.add(MovedThing{.before = {}, .after = door, .time = close, .back = open});
    return (close + open) / 2;
  }

  /// @return [s] since the drive began, until which the robot is at a waypoint of the route
  double latestArrival(std::size_t waypoint) const {
    constexpr double kSpeedUp = 1.5, kTurnUp = 1.0;  // [s] that a way and a turn take beyond those at full speed
    double time = scene_.settle;
    Pose2 at;
    for (std::size_t i = 0; i <= waypoint; ++i) {
      const Waypoint& next = scene_.route[i];
      const Eigen::Vector2d way = next.pose.translation() - at.translation();
      const double heading = std::atan2(way.y(), way.x());
      const double turn =
          std::abs(wrapAngle(heading - at.theta)) + (next.stop ? std::abs(wrapAngle(next.pose.theta - heading)) : 0.0);
      time += way.norm() / scene_.speed + turn / scene_.turn_rate + kSpeedUp + 2.0 * kTurnUp;
      if (i < waypoint) time += next.pause;
      at = {next.pose.x, next.pose.y, next.stop ? next.pose.theta : heading};
    }
    return time;
  }

  void addSide(const std::vector<double>& widths, double depth, double side) {
    World& world = scene_.world;
    double left = -kStart;
    for (const double width : widths) {
      const double right = left + width;
      Room room{left, right, side, depth, uniform(left + 0.8, right - 0.8)};
      // The first metre belongs to the start, whose door would lie beside it.
      room.door = std::max(room.door, std::min(0.6, right - 0.8));
      const double wall = side * half_;
      world.addWall({left, wall}, {room.door - kDoor / 2, wall});
      world.addWall({room.door + kDoor / 2, wall}, {right, wall});
      if (&width != &widths.back()) {
        world.addWall({right, wall}, {right, side * (half_ + depth)});
      }
      // The leaf stands open on the side away from the room's middle.
      const double hinge = room.middle() < room.door ? 1.0 : -1.0, angle = uniform(85.0, 95.0) * kDegree;
      const Eigen::Vector2d foot(room.door + hinge * (kDoor / 2 + 0.03), wall + side * 0.05);
      world.addWall(foot, foot + 0.85 * Eigen::Vector2d(-hinge * std::cos(angle), side * std::sin(angle)), 0.04, 2.0);
      rooms_.push_back(room);
      left = right;
    }
  }

  void pass(double x, double y) { scene_.route.push_back({.pose = {x, y, 0.0}, .stop = false, .pause = 0.0}); }

  void addRoute() {
    std::vector<Room> order = rooms_;
    std::sort(order.begin(), order.end(), [](const Room& a, const Room& b) { return a.door < b.door; });
    for (const Room& room : order) {
      const double inside = room.side * (half_ + 0.65);
      pass(room.door, 0.0);
      pass(room.door, inside);
      scene_.route.push_back(
          {.pose = {room.middle(), room.side * (half_ + 0.5 * room.depth), uniform(-kPi, kPi)}, .measured = true});
      pass(room.door, inside);
      pass(room.door, 0.0);
    }
    scene_.route.push_back({.pose = {0.0, 0.0, 0.0}, .measured = true});
  }

  Solids furnitureOf(std::uint64_t seed, int floor) {
    if (floor != 0) random_.seed(seed * 104729 + static_cast<std::uint64_t>(floor));
    Solids furniture;
    for (const Room& room : rooms_) furniture.append(furnish(room));
    return furniture;
  }

  Solids furnish(const Room& room) {
    std::vector<Item> items;
    const int pieces = std::uniform_int_distribution<int>(3, 5)(random_);
    for (int i = 0; i < pieces; ++i) {
      const int kind = std::uniform_int_distribution<int>(0, 4)(random_);
      for (int tries = 0; tries < 50; ++tries) {
        const Item item = make(kind, room);
        if (!fits(item, room, items, items.size())) continue;
        items.push_back(item);
        break;
      }
    }
    for (std::size_t i = 0; moved_ && i < items.size(); ++i) {
      for (int tries = 0; tries < 200; ++tries) {
        const double way = between(moves_, 0.5, 1.0), direction = between(moves_, -kPi, kPi);
        const Item item = shifted(items[i], way * Eigen::Vector2d(std::cos(direction), std::sin(direction)));
        if (!fits(item, room, items, i)) continue;
        items[i] = item;
        break;
      }
    }
    Solids furniture;
    for (const Item& item : items) furniture.append(item.solids);
    return furniture;
  }

  Item make(int kind, const Room& room) {
    const double low = room.side * half_, high = room.side * (half_ + room.depth);
    const double x = uniform(room.left, room.right), y = uniform(std::min(low, high), std::max(low, high));
    const double yaw = uniform(0.0, 1.0) < 0.5 ? 0.0 : kPi / 2;
    Item item{.centre = {x, y}};
    const auto box = [&](double length, double width, double turn, double top) {
      item.solids.boxes.push_back({x, y, turn, length, width, 0.0, top});
      item.radius = std::hypot(length, width) / 2;
    };
    if (kind == 0) {
      box(uniform(0.9, 1.6), uniform(0.4, 0.6), yaw, 1.9);  // cupboard
    } else if (kind == 1) {
      box(2.0, uniform(0.9, 1.4), yaw, 0.5);  // bed
    } else if (kind == 2) {
      box(uniform(0.4, 0.7), uniform(0.3, 0.5), uniform(0.0, kPi), 0.6);  // crate
    } else if (kind == 3) {
      item.solids = chair(x, y);
      item.radius = 0.3;
    } else {
      item.radius = uniform(0.15, 0.3);
      item.solids.cylinders.push_back({x, y, item.radius, 0.0, 1.0});  // plant
    }
    return item;
  }

  static Item shifted(Item item, const Eigen::Vector2d& by) {
    item.centre += by;
    for (Box& box : item.solids.boxes) box.x += by.x(), box.y += by.y();
    for (Cylinder& cylinder : item.solids.cylinders) cylinder.x += by.x(), cylinder.y += by.y();
    return item;
  }

  /// In the room, off the other items but number `self`, and off the route.
  bool fits(const Item& item, const Room& room, const std::vector<Item>& others, std::size_t self) const {
    const Bounds bounds = item.solids.bounds();
    const double low = room.side > 0.0 ? half_ : -half_ - room.depth;
    if (bounds.low.x() < room.left + 0.06 || bounds.high.x() > room.right - 0.06 || bounds.low.y() < low + 0.06 ||
        bounds.high.y() > low + room.depth - 0.06)
      return false;
    for (std::size_t i = 0; i < others.size(); ++i) {
      if (i != self && (others[i].centre - item.centre).norm() < others[i].radius + item.radius) return false;
    }
    Eigen::Vector2d from = Eigen::Vector2d::Zero();
    for (const Waypoint& waypoint : scene_.route) {
      const Eigen::Vector2d to = waypoint.pose.translation();
      const int steps = static_cast<int>((to - from).norm() / 0.05) + 1;
      for (int i = 0; i <= steps; ++i) {
        if (item.solids.occupied(from + (to - from) * i / steps, 0.0, 0.8, kClearance)) return false;
      }
      from = to;
    }
    return true;
  }

  static double between(std::mt19937_64& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double uniform(double low, double high) { return between(random_, low, high); }

  Scene& scene_;
  double half_;  // [m] of the corridor's width
  std::mt19937_64 random_, moves_;
  bool moved_;
  std::vector<Room> rooms_;
};

}  // namespace

Scene home(int furniture_moved) {
  Scene scene{.name = "home", .speed = 0.4, .turn_rate = 45 * kDegree};
  HomeBuilder(scene, {.rooms_below = {3.0, 5.2, 3.8}, .rooms_above = {4.6, 3.2, 4.2}}, 2024,
              {.furniture_moved = furniture_moved});
  return scene;
}

Scene homes(std::uint64_t seed, int furniture_moved, int floor, const std::optional<int>& lift) {
  Scene scene{.name = "homes", .speed = 0.4, .turn_rate = 45 * kDegree};
  const std::uint64_t number = (seed + kHomes - 1) % kHomes;
  std::mt19937_64 random(1000 + number);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double length = uniform(9.0, 14.0);
  const auto rooms = [&] {
    std::vector<double> widths(static_cast<std::size_t>(std::uniform_int_distribution<int>(2, 3)(random)));
    for (double& width : widths) width = uniform(1.0, 1.6);
    const double sum = std::accumulate(widths.begin(), widths.end(), 0.0);
    for (double& width : widths) width *= length / sum;
    return widths;
  };
  HomePlan plan{.corridor = uniform(1.2, 1.8), .below = uniform(2.8, 4.2), .above = uniform(2.8, 4.2)};
  plan.rooms_below = rooms();
  plan.rooms_above = rooms();
  HomeBuilder(scene, plan, 2000 + number, {.furniture_moved = furniture_moved, .floor = floor, .lift = lift});
  return scene;
}

}  // namespace slam::sim
