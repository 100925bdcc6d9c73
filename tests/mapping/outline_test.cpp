// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/outline.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::outline_test {
namespace {

const Outline kL{{0.0, 0.0}, {4.0, 0.0}, {4.0, 1.0}, {1.0, 1.0}, {1.0, 3.0}, {0.0, 3.0}};  // [m]

TEST(Outline, HoldsWhatLiesInIt) {
  EXPECT_TRUE(holds(kL, {0.5, 2.5}));
  EXPECT_TRUE(holds(kL, {3.5, 0.5}));
  EXPECT_FALSE(holds(kL, {2.0, 2.0}));
  EXPECT_FALSE(holds(kL, {-0.1, 0.5}));
  EXPECT_FALSE(holds(kL, {4.1, 0.5}));
}

TEST(Outline, HoldsTheSameWhicheverWayItsCornersGo) {
  const Outline reversed(kL.rbegin(), kL.rend());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 5.0);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d p(uniform(random), uniform(random));
    const bool inside = p.x() > 0.0 && p.y() > 0.0 && ((p.x() < 4.0 && p.y() < 1.0) || (p.x() < 1.0 && p.y() < 3.0));
    EXPECT_EQ(holds(kL, p), inside) << p.transpose();
    EXPECT_EQ(holds(reversed, p), inside) << p.transpose();
  }
}

TEST(Outline, CrossesItselfWhereEdgesMeet) {
  EXPECT_FALSE(crossesItself(kL));
  EXPECT_FALSE(crossesItself(Outline{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}));
  EXPECT_TRUE(crossesItself(Outline{{0.0, 0.0}, {1.0, 1.0}, {1.0, 0.0}, {0.0, 1.0}}));              // a bow tie
  EXPECT_TRUE(crossesItself(Outline{{0.0, 0.0}, {2.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}));              // back on its way
  EXPECT_TRUE(crossesItself(Outline{{0.0, 0.0}, {0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}));              // a corner twice
  EXPECT_TRUE(crossesItself(Outline{{0.0, 0.0}, {4.0, 0.0}, {4.0, 2.0}, {2.0, 0.0}, {0.0, 2.0}}));  // touches
  EXPECT_TRUE(crossesItself(Outline{{0.0, 0.0}, {1.0, 0.0}, {2.0, 0.0}}));                          // no area
}

TEST(Outline, DistanceIsToTheNearestPointOfALine) {
  EXPECT_DOUBLE_EQ(distanceTo({0.0, 0.0}, {2.0, 0.0}, {1.0, 1.5}), 1.5);
  EXPECT_DOUBLE_EQ(distanceTo({0.0, 0.0}, {2.0, 0.0}, {5.0, 4.0}), 5.0);
  EXPECT_DOUBLE_EQ(distanceTo({1.0, 1.0}, {1.0, 1.0}, {4.0, 5.0}), 5.0);
}

TEST(Outline, IsTouchedByWhatIsNearOneOfItsEdges) {
  const Outline corner{{0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}};
  for (const bool closed : {false, true}) {
    EXPECT_TRUE(touches(corner, closed, {1.0, -0.1}, 0.11));
    EXPECT_FALSE(touches(corner, closed, {1.0, -0.1}, 0.09));
    EXPECT_FALSE(touches(corner, closed, {2.09, 2.09}, 0.1)) << "by its distance, not by a box around the edge";
    EXPECT_EQ(touches(corner, closed, {1.0, 1.0}, 0.1), closed) << "the edge from the last corner to the first";
  }
}

TEST(Outline, BoundsHoldAllCorners) {
  const Bounds bounds = Bounds::of(kL);
  EXPECT_EQ(bounds.low, Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(bounds.high, Eigen::Vector2d(4.0, 3.0));
  EXPECT_TRUE(bounds.meets({{4.0, 3.0}, {5.0, 5.0}}));
  EXPECT_FALSE(bounds.meets({{4.1, 0.0}, {5.0, 5.0}}));
  EXPECT_TRUE(bounds.grown(0.2).meets({{4.1, 0.0}, {5.0, 5.0}}));
}

}  // namespace
}  // namespace slam::outline_test
