// SPDX-License-Identifier: BSD-3-Clause
#include "slam/pipeline.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <span>
#include <vector>

#include "support/simulated/robot.hpp"

namespace slam::pipeline_test {
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

constexpr Pose2 kMounting{0.12, 0.05, 0.6};

/// What a lidar in that place sees of a long hall, and of a post that the robot carries beside it.
struct HallWithPost {
  double reach = 8.0;  // [m]

  double range(const Pose2& T_world_base, double bearing) const {
    if (std::abs(wrapAngle(bearing - 1.75)) < 0.2) return 0.3;
    return test::Room{.length = 30.0, .width = 5.0}.range(T_world_base * kMounting, bearing);
  }
};

/// A drive with the lidar one way up or the other.
struct MountedDrive {
  static PipelineConfig settings(bool upside_down) {
    PipelineConfig config;
    config.front_end.lidar.T_base_lidar = kMounting;
    config.front_end.lidar.upside_down = upside_down;
    return config;
  }
  explicit MountedDrive(bool upside_down_) : upside_down(upside_down_), pipeline(settings(upside_down_)) {}

  void add(const WheelSample& sample) { pipeline.add(sample); }
  void add(const ImuSample& sample) { pipeline.add(sample); }
  void add(LaserScan scan) {
    if (upside_down)
      for (Beam& beam : std::span(scan.storage).first(static_cast<std::size_t>(scan.size))) beam.bearing *= -1.0F;
    const ScanOutcome outcome = pipeline.add(scan);
    if (outcome.keyframe != nullptr) body = outcome.keyframe->body;
  }

  const bool upside_down;
  BodyShape body;  // of the last keyframe
  Pipeline pipeline;
};

TEST(Pipeline, ADriveWithTheLidarUpsideDownIsTheSameDriveUpright) {
  MountedDrive upright(false), turned(true);
  for (MountedDrive* drive : {&upright, &turned}) {
    test::SimulatedRobot robot(HallWithPost{}, {-12.0, 0.5, 0.1});
    robot.lidar.sweep = 0.1;
    robot.gyro.bias = 0.01;
    robot.run(8.0, {0.3, 0.0, 0.2}, *drive);
    robot.run(8.0, {0.3, 0.0, -0.4}, *drive);
    robot.run(8.0, {0.3, 0.0, 0.2}, *drive);
    const Pose2 moved = drive->pipeline.frontEnd().estimate(robot.now).T_map_base;
    const Pose2 truth = between(Pose2{-12.0, 0.5, 0.1}, robot.truth);
    EXPECT_LT((moved.translation() - truth.translation()).norm(), 0.05);
  }
  const auto pose = [](const MountedDrive& drive) {
    return drive.pipeline.frontEnd().estimate(drive.pipeline.frontEnd().newestStamp()).T_map_base;
  };
  const Pose2 apart = between(pose(upright), pose(turned));
  EXPECT_LT(apart.translation().norm(), 1e-3);
  EXPECT_NEAR(apart.theta, 0.0, 1e-3);
  ASSERT_GT(upright.body.degrees(), 15);
  EXPECT_NEAR(turned.body.degrees(), upright.body.degrees(), 1);
  EXPECT_NEAR(turned.body.middle(), upright.body.middle(), 1.5);
  EXPECT_EQ(turned.pipeline.backEnd().keyframes().size(), upright.pipeline.backEnd().keyframes().size());
  int seen = 0, differ = 0;
  const OccupancyGrid &one = upright.pipeline.mapper().grid(), &other = turned.pipeline.mapper().grid();
  for (double x = -10.0; x < 18.0; x += one.resolution()) {
    for (double y = -6.0; y < 6.0; y += one.resolution()) {
      const auto cell = one.cellAt({x, y});
      const int here = one.logOdds(cell), there = other.logOdds(cell);
      seen += here != 0;
      differ += (here > 0) != (there > 0) || (here < 0) != (there < 0);
    }
  }
  EXPECT_GT(seen, 10000);
  EXPECT_LT(differ, seen / 50);
}

}  // namespace
}  // namespace slam::pipeline_test
