// SPDX-License-Identifier: BSD-3-Clause
#include "slam/pipeline.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "support/simulated/robot.hpp"

namespace slam {
namespace {

/// The same samples for whoever wants them: a curve through a room, with wheels and gyro.
void feed(auto& sink) {
  test::SimulatedRobot(test::Room{.length = 8.0, .width = 5.0}).run(12.0, {0.3, 0.0, 0.4}, sink);
}

TEST(Pipeline, ItsStepsGiveWhatTheyGiveTogether) {
  Pipeline whole({});
  struct InSteps : Pipeline {
    using Pipeline::Pipeline, Pipeline::add;
    void add(const LaserScan& scan) {
      const ScanOutcome outcome = match(scan);
      if (outcome.keyframe != nullptr) build(*outcome.keyframe);
      correct();
      EXPECT_EQ(correction(), nullptr);
    }
  } stepped(PipelineConfig{});
  feed(whole);
  feed(stepped);
  const Timestamp now = whole.frontEnd().newestStamp();
  EXPECT_EQ(whole.frontEnd().estimate(now).T_map_base, stepped.frontEnd().estimate(now).T_map_base);
  EXPECT_GT(whole.backEnd().keyframes().size(), 3);
  EXPECT_EQ(whole.backEnd().keyframes().size(), stepped.backEnd().keyframes().size());
  EXPECT_EQ(whole.mapper().keyframes(), whole.backEnd().keyframes().size());
  EXPECT_GT(whole.mapper().grid().tiles().tileCount(), 0);
}

TEST(Pipeline, CallsOnScanBeforeTheKeyframeIsInTheMapAndOnUpdateBehindThat) {
  Pipeline pipeline({});
  int scans = 0, updates = 0, known = 0;
  bool pending = false;
  pipeline.on_scan = [&](const ScanOutcome& outcome) {
    ++scans;
    EXPECT_EQ(pipeline.backEnd().keyframes().size(), known);
    pending = outcome.keyframe != nullptr;
  };
  pipeline.on_update = [&](const MapUpdate&) {
    ++updates;
    EXPECT_TRUE(pending);
    known = pipeline.backEnd().keyframes().size();
  };
  feed(pipeline);
  EXPECT_EQ(scans, 60);
  EXPECT_GE(updates, known);
  EXPECT_GT(known, 3);
}

TEST(Pipeline, GoesOnInTheStateThatItGave) {
  Pipeline first({});
  feed(first);
  const MapState state = first.state();
  const Pipeline next({}, state);
  EXPECT_FALSE(next.frontEnd().placed()) << "the robot has to be found";
  EXPECT_EQ(next.backEnd().keyframes().size(), first.backEnd().keyframes().size());
  EXPECT_EQ(next.mapper().keyframes(), first.mapper().keyframes());
  EXPECT_EQ(next.mapper().grid().tiles().tileCount(), first.mapper().grid().tiles().tileCount());
}

TEST(Pipeline, WhatIsNotDrawnIsMatchedAlike) {
  Pipeline drawn({});
  PipelineConfig config;
  config.draws = false;
  Pipeline bare(config);
  feed(drawn);
  feed(bare);
  const Timestamp now = drawn.frontEnd().newestStamp();
  EXPECT_EQ(drawn.frontEnd().estimate(now).T_map_base, bare.frontEnd().estimate(now).T_map_base);
}

TEST(Pipeline, IsFittedToAFloorPlanAlone) {
  MapState map;
  const double usual = MatchConfig{}.overlap_distance;
  EXPECT_EQ(fitted({}, map).front_end.match.overlap_distance, usual);
  map.kind = MapKind::kFloorPlan;
  const PipelineConfig config = fitted({}, map);
  EXPECT_EQ(config.front_end.match.overlap_distance, usual + 0.5 * map.grid.resolution());
  EXPECT_EQ(config.back_end.match.overlap_distance, usual + 0.5 * map.grid.resolution());
  EXPECT_EQ(PipelineConfig().back_end.relocalisation.places.model.kind, MapKind::kScans);
  EXPECT_EQ(config.back_end.relocalisation.places.model.kind, MapKind::kFloorPlan);
}

}  // namespace
}  // namespace slam
