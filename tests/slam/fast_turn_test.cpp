// SPDX-License-Identifier: BSD-3-Clause
// A robot that turns faster than its scans follow, where corridors cross that look alike: the whole pipeline.
#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "slam/robot.hpp"

namespace slam::fast_turn_test {
namespace {

using test::Robot;

constexpr double kTold = 0.5;  // [m] a pose that is further off is wrong

/// A wall along a corridor with deep doors. @param along, outwards unit vectors
void addDoors(sim::World& world, Eigen::Vector2d from, const Eigen::Vector2d& along, const Eigen::Vector2d& outwards,
              double length, std::mt19937& random) {
  std::uniform_real_distribution<double> wall(1.5, 5.0);
  const Eigen::Vector2d depth = 0.6 * outwards;
  for (double s = 0.0; s < length;) {
    const double plain = wall(random);
    const Eigen::Vector2d left = from + plain * along, right = left + 0.9 * along;
    world.addWall(from, left);
    world.addWall(left, left + depth);
    world.addWall(left + depth, right + depth);
    world.addWall(right + depth, right);
    from = right;
    s += plain + 0.9;
  }
}

/// Two corridors that cross at the origin.
test::Place crossing(unsigned seed) {
  test::Place place{.name = "Crossing", .low = {-20, -1}, .high = {20, 1}, .reach = 15.0};
  std::mt19937 random(seed);
  const Eigen::Vector2d x(1, 0), y(0, 1);
  for (const double right : {-1.0, 1.0}) {
    for (const double up : {-1.0, 1.0}) {
      const Eigen::Vector2d corner(1.1 * right, 1.0 * up);
      addDoors(place.world, corner, right * x, up * y, 40.0, random);
      addDoors(place.world, corner, up * y, right * x, 40.0, random);
    }
  }
  return place;
}

struct Wheels {
  const char* name;
  bool there;
  double slip;  ///< [1] of the way, one way and the other
};

/// A robot with a lidar that sees ahead and to the sides, which turns left at the crossing.
class Turn {
 public:
  explicit Turn(unsigned seed, const Wheels& wheels) : robot_(crossing(seed), {-15.0 - 0.013 * seed, 0.1, 0.0}) {
    robot_.look(std::numbers::pi);
    robot_.gyro.there = false;
    robot_.wheels.there = wheels.there;
    const double straight = (std::abs(robot_.truth.x) - 0.96 - 0.4) / 1.6;  // [s]
    speedUp();
    for (int i = 0; i < 10; ++i) {
      robot_.wheels.scale = 1.01 + (i % 2 == 0 ? 1.0 : -1.0) * wheels.slip;
      robot_.run(straight / 10, {1.6, 0.0, 0.0});
    }
    robot_.wheels.scale = 1.01;
    // What bad wheels did on the way is not the matter here.
    T_world_map_ = robot_.truth * robot_.estimate().T_map_base.inverse();
  }

  bool wheelsHeard() const { return robot_.pipeline.frontEnd().counters().wheels_reliable; }
  /// @param rate [rad/s]  @return poses that were wrong and called good
  int run(double rate) {
    int wrong = 0;
    robot_.after_scan = [&] { wrong += error() > kTold && state() == LocalisationState::kLocalised; };
    double speed = 1.2;  // [m/s]
    for (const double end = robot_.truth.theta + std::numbers::pi / 2; robot_.truth.theta < end; speed *= 0.96) {
      robot_.run(0.02, {speed, 0.0, rate});
    }
    speedUp();
    robot_.run(5.0, {1.6, 0.0, 0.0});
    return wrong;
  }
  double error() const { return robot_.error(T_world_map_); }  // [m]
  LocalisationState state() const { return robot_.state(); }

 private:
  void speedUp() {
    for (const double speed : {0.4, 0.8, 1.2}) robot_.run(0.4, {speed, 0.0, 0.0});
  }

  Robot robot_;
  Pose2 T_world_map_;
};

class FastTurn : public testing::TestWithParam<Wheels> {};

TEST_P(FastTurn, IsFollowed) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    Turn turn(seed, GetParam());
    if (GetParam().there) {
      EXPECT_EQ(turn.wheelsHeard(), GetParam().slip == 0.0) << seed;
    }
    EXPECT_EQ(turn.run(2.4), 0) << "seed " << seed;
    EXPECT_EQ(turn.state(), LocalisationState::kLocalised) << "seed " << seed;
    EXPECT_LT(turn.error(), kTold) << "seed " << seed;
  }
}

TEST(FasterTurn, ThatNothingFollowsIsAdmitted) {
  int wrong = 0;
  for (unsigned seed = 0; seed < 12; ++seed) wrong += Turn(seed, {"NoWheels", false, 0.0}).run(4.0) > 0;
  EXPECT_LE(wrong, 4) << "of 12, where the first match after the turn leads to another corridor at once";
}

INSTANTIATE_TEST_SUITE_P(With, FastTurn,
                         testing::Values(Wheels{"NoWheels", false, 0.0}, Wheels{"GoodWheels", true, 0.0},
                                         Wheels{"WheelsThatSlip", true, 0.6}),
                         [](const auto& wheels) { return wheels.param.name; });

}  // namespace
}  // namespace slam::fast_turn_test
