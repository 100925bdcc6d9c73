// SPDX-License-Identifier: BSD-3-Clause
#include "slam/pipeline.hpp"

#include <chrono>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <vector>

#include "support/simulated/room.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

/// The same samples for whoever wants them: a curve through a room, with wheels and gyro.
class Samples {
 public:
  /// @param take a scan
  template <typename Take>
  void feed(Pipeline& pipeline, const Take& take) {
    std::mt19937 random(1);
    const test::Room room{.length = 8.0, .width = 5.0, .range_sigma = 0.01};
    Pose2 truth;
    Timestamp now{100s};
    for (int step = 1; step <= 600; ++step) {
      now += 20ms;
      truth = truth * exp(Eigen::Vector3d(0.006, 0.0, 0.008));
      pipeline.add(WheelSample{now, truth});
      pipeline.add(ImuSample{now, {0, 0, 0.4}, {0, 0, 9.81}});
      if (step % 10 != 0) continue;
      LaserScan scan = room.scan(truth, random);
      scan.stamp = now;
      take(scan);
    }
  }
};

TEST(Pipeline, ItsStepsGiveWhatTheyGiveTogether) {
  Pipeline whole({}), stepped({});
  Samples samples;
  samples.feed(whole, [&](const LaserScan& scan) { whole.add(scan); });
  samples.feed(stepped, [&](const LaserScan& scan) {
    const ScanOutcome outcome = stepped.match(scan);
    if (outcome.keyframe != nullptr) stepped.build(*outcome.keyframe);
    stepped.correct();
    EXPECT_EQ(stepped.correction(), nullptr);
  });
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
  Samples().feed(pipeline, [&](const LaserScan& scan) { pipeline.add(scan); });
  EXPECT_EQ(scans, 60);
  EXPECT_GE(updates, known);
  EXPECT_GT(known, 3);
}

TEST(Pipeline, GoesOnInTheStateThatItGave) {
  Pipeline first({});
  Samples samples;
  samples.feed(first, [&](const LaserScan& scan) { first.add(scan); });
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
  Samples samples;
  samples.feed(drawn, [&](const LaserScan& scan) { drawn.add(scan); });
  samples.feed(bare, [&](const LaserScan& scan) { bare.add(scan); });
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
