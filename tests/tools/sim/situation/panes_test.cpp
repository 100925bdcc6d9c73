// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/panes.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tools/sim/world/furniture.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim::panes_test {
namespace {

/// A room of 4 x 4 m about the origin, whose east wall, inner face at x = 2, has a pane over all of it.
struct Room {
  World world;
  Panes panes;

  explicit Room(bool mirror) : panes({{Box{2.055, 0.0, 0.0, 0.1, 4.0}, mirror}}, 1) {
    addRoom(world, -2.06, -2.06, 2.06, 2.06);
  }
  double cast(double direction, double reach = 12.0) {
    return panes.castRay(world, {0.0, 0.0, 0.18}, {std::cos(direction), std::sin(direction), 0.0}, reach);
  }
};

TEST(Panes, AWindowIsSeenSquarelyAndElsewhereOnlyByItsDirt) {
  Room room(false);
  int back = 0;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_NEAR(room.cast(0.1), 2.005 / std::cos(0.1), 1e-9);
    const double range = room.cast(0.6);
    if (!std::isinf(range)) {
      ++back;
      EXPECT_NEAR(range, 2.005 / std::cos(0.6), 1e-9);
    }
  }
  EXPECT_NEAR(back, 200, 50);
  EXPECT_NEAR(room.cast(3.14159265), 2.01, 1e-6);  // the wall behind
}

TEST(Panes, AMirrorShowsWhatItReflects) {
  Room room(true);
  EXPECT_NEAR(room.cast(0.0), 2.005 + 2.005 + 2.01, 1e-6);  // to the wall behind
  const double slant = 0.3;
  EXPECT_NEAR(room.cast(slant), (2.005 + 2.005 + 2.01) / std::cos(slant), 1e-6);
  EXPECT_TRUE(std::isinf(room.cast(0.0, 5.0)));
}

TEST(Panes, AreDrawnOnWallsBySeed) {
  const World world = makeScene("home", 1).world;
  const Panes a = Panes::drawn(world, 6, 2, 3), same = Panes::drawn(world, 6, 2, 3),
              other = Panes::drawn(world, 6, 2, 4);
  ASSERT_EQ(a.panes().size(), 8U);
  EXPECT_EQ(a.panes()[0].box.x, same.panes()[0].box.x);
  EXPECT_NE(a.panes()[0].box.x, other.panes()[0].box.x);
  for (std::size_t i = 0; i < 8; ++i) {
    const Box& box = a.panes()[i].box;
    EXPECT_EQ(a.panes()[i].mirror, i >= 6);
    EXPECT_GE(box.length, 1.0);
    EXPECT_LE(box.length, 2.0);
    EXPECT_TRUE(world.occupied({box.x, box.y}, 0.1, 0.3));
  }
  EXPECT_TRUE(Panes::drawn(World{}, 6, 2, 3).panes().empty());
}

}  // namespace
}  // namespace slam::sim::panes_test
