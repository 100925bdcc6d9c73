// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/moving_things.hpp"

#include <gtest/gtest.h>

namespace slam::sim::moving_things_test {
namespace {

const Person kWalker{.path = {{2.0, -1.0}, {2.0, 1.0}, {3.0, 1.0}}, .speed = 0.5, .begin = 10.0, .end = 40.0};

TEST(Person, WalksItsPathToAndFroAtItsSpeed) {
  EXPECT_NEAR((kWalker.position(10.0) - Eigen::Vector2d(2.0, -1.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((kWalker.position(12.0) - Eigen::Vector2d(2.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((kWalker.position(15.0) - Eigen::Vector2d(2.5, 1.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((kWalker.position(17.0) - Eigen::Vector2d(2.5, 1.0)).norm(), 0.0, 1e-12);  // 6 s there, 1 s back
  EXPECT_NEAR((kWalker.position(22.0) - Eigen::Vector2d(2.0, -1.0)).norm(), 0.0, 1e-12);
}

TEST(Person, IsThereOnlyBetweenItsTimes) {
  for (const double time : {0.0, 9.99, 40.0, 100.0}) {
    Solids solids;
    kWalker.addTo(solids, time);
    EXPECT_TRUE(solids.cylinders.empty()) << time;
  }
}

TEST(Person, HasTwoLegsApartAndATorsoAboveThem) {
  double widest = 0.0;
  for (double time = 10.0; time < 40.0; time += 0.1) {
    Solids solids;
    kWalker.addTo(solids, time);
    ASSERT_EQ(solids.cylinders.size(), 3U);
    const auto &right = solids.cylinders[0], &left = solids.cylinders[1], &torso = solids.cylinders[2];
    EXPECT_EQ(left.top, torso.bottom);
    EXPECT_EQ(torso.top, 1.7);
    const double apart = std::hypot(left.x - right.x, left.y - right.y);
    EXPECT_GT(apart, 2 * Person::kLegRadius);  // legs do not run through each other
    widest = std::max(widest, apart);
  }
  EXPECT_NEAR(widest, std::hypot(Person::kFeetApart, 2 * Person::kSwing), 0.01);
}

}  // namespace
}  // namespace slam::sim::moving_things_test
