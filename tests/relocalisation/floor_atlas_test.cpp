// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/floor_atlas.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <numeric>

#include "support/simulated/keyframes.hpp"

namespace slam::test::floor_atlas_test {
namespace {

KeyframeGraph ringMap(unsigned seed) {
  KeyframeDrive drive(ringCorridor(), seed);
  KeyframeGraph map;
  for (double s = 0.0; s < 40.0; s += 0.5)
    map.add(std::make_shared<const StoredScan>(drive.at(onRing(s), {}, {0.002, 0.002, 0.0005})), onRing(s));
  return map;
}

TEST(FloorAtlas, LaysMapsSideBySideAndGivesEachPlaceInItsOwnFrame) {
  const KeyframeGraph present = ringMap(1), other = ringMap(2);
  std::vector<int> ids(static_cast<std::size_t>(present.size()));
  std::iota(ids.begin(), ids.end(), 0);
  std::vector<char> in_map(static_cast<std::size_t>(other.size()), 1);
  in_map[3] = 0;
  const Floors floors{"ground", {std::make_shared<const FloorMap>(FloorMap{"first", other, in_map})}};
  const FloorAtlas atlas(present, ids, floors, 40.0);
  ASSERT_EQ(atlas.keyframes().size(), present.size() + other.size() - 1) << "what was never found is left out";
  for (int id = 0; id < present.size(); ++id) {
    EXPECT_EQ(atlas.keyframes().pose(id), present.pose(id)) << "the present map keeps its frame";
    EXPECT_EQ(atlas.placeOf(atlas.keyframes().pose(id)).floor, 0);
  }
  const auto place = atlas.placeOf(atlas.keyframes().pose(present.size()));
  EXPECT_EQ(place.floor, 1);
  EXPECT_NEAR(place.T_floor_base.x, other.pose(0).x, 1e-9);
  EXPECT_NEAR(place.T_floor_base.y, other.pose(0).y, 1e-9);
  EXPECT_EQ(place.T_floor_base.theta, other.pose(0).theta);
  EXPECT_EQ(floors.name(0), "ground");
  EXPECT_EQ(floors.name(1), "first");
  for (int id = present.size(); id < atlas.keyframes().size(); ++id)
    EXPECT_GT(atlas.keyframes().pose(id).x, 7.0 + 40.0) << "no scan reaches from one map to the other";
}

TEST(FloorAtlas, TakesAMapThatHoldsNothing) {
  const Floors floors{"empty", {std::make_shared<const FloorMap>(FloorMap{"nothing", {}, {}})}};
  const FloorAtlas atlas(KeyframeGraph{}, {}, floors, 40.0);
  EXPECT_EQ(atlas.keyframes().size(), 0);
  EXPECT_EQ(atlas.placeOf({1.0, 2.0, 0.5}).floor, 0);
}

}  // namespace
}  // namespace slam::test::floor_atlas_test
