// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_builder.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <utility>
#include <vector>

#include "support/simulated/keyframes.hpp"

namespace slam {
namespace {

using test::onRing;

const Eigen::Vector3d kDrift(0.01, 0.01, 0.002);  // [m, m, rad] a step
constexpr double kStep = 0.5, kRound = 40.0;      // [m]

TEST(MapBuilder, NamesWhatEachKeyframeChanged) {
  test::KeyframeDrive drive(test::ringCorridor());
  MapBuilder builder({});
  std::vector<Pose2> poses;
  int closed = 0, drawn = 0;
  for (double s = 0.0; s < 1.2 * kRound; s += kStep) {
    const int generation = builder.backEnd().generation();
    MapUpdate update = builder.add(drive.at(onRing(s), kDrift));
    drawn += static_cast<int>(update.scans.size());
    EXPECT_EQ(update.poses.empty(), builder.backEnd().generation() == generation);
    if (!update.poses.empty()) {
      const auto now = builder.backEnd().keyframes().graph().poses();
      EXPECT_TRUE(std::equal(update.poses.begin(), update.poses.end(), now.begin(), now.end()));
    }
    closed += update.loop_closed ? 1 : 0;
    EXPECT_FALSE(update.relocalised || update.begun_anew);
    EXPECT_EQ(update.first_in_map, 0);
    if (update.correction) builder.recycle(std::move(update.correction));
  }
  EXPECT_GT(closed, 0);
  EXPECT_EQ(drawn, builder.backEnd().keyframes().size());
}

TEST(MapBuilder, MakesNoCorrectionBeforeTheLastOneIsGivenBack) {
  test::KeyframeDrive drive(test::ringCorridor());
  MapBuilder builder({});
  std::unique_ptr<MapCorrection> away;
  double s = 0.0;
  for (; s < 1.2 * kRound && !away; s += kStep) away = builder.add(drive.at(onRing(s), kDrift)).correction;
  ASSERT_TRUE(away);
  const double first = s;
  for (; s < first + kRound; s += kStep) EXPECT_EQ(builder.add(drive.at(onRing(s), kDrift)).correction, nullptr) << s;
  builder.recycle(std::move(away));
  for (; s < first + 2.0 * kRound && !away; s += kStep) away = builder.add(drive.at(onRing(s), kDrift)).correction;
  EXPECT_TRUE(away);
}

TEST(MapBuilder, GoesOnInTheStateThatItGave) {
  test::KeyframeDrive drive(test::ringCorridor());
  MapBuilder first({});
  for (double s = 0.0; s < 10.0; s += kStep) first.add(drive.at(onRing(s), kDrift));
  const MapState state = first.state({OccupancyGrid(OccupancyGridConfig{}), {}}, 5);
  EXPECT_EQ(state.keyframes.size(), 20);
  EXPECT_EQ(state.grid_keyframes, 5);
  const MapBuilder next({}, state);
  ASSERT_EQ(next.backEnd().keyframes().size(), 20);
  for (int id = 0; id < 20; ++id) {
    EXPECT_EQ(next.backEnd().keyframes().pose(id), first.backEnd().keyframes().pose(id));
    EXPECT_TRUE(next.backEnd().map().inMap(id));
  }
}

}  // namespace
}  // namespace slam
