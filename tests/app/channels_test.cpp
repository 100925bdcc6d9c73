// SPDX-License-Identifier: BSD-3-Clause
#include "app/channels.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <type_traits>

#include "frontend/front_end.hpp"

namespace slam::channels_test {
namespace {

template <typename End, typename T>
constexpr bool kGives = requires(End end, T value) {
  end.tryPush(value);
};
template <typename End, typename T>
constexpr bool kTakes = requires(End end) {
  end.drain([](T&) {});
};

/// Neither end can do, or become, what the other one is for.
template <typename T>
constexpr bool kOneWay =
    kGives<Producer<T>, T> && !kTakes<Producer<T>, T> && kTakes<Consumer<T>, T> && !kGives<Consumer<T>, T> &&
    !std::is_constructible_v<Producer<T>, Consumer<T>> && !std::is_constructible_v<Consumer<T>, Producer<T>>;
static_assert(kOneWay<int> && kOneWay<Keyframe> && kOneWay<MapCorrection*>);

// What one thread gives, the other takes.
static_assert(kTakes<decltype(EstimatorEnds::samples.scans), ReceivedScan>);
static_assert(kGives<decltype(BusEnds::samples.scans), ReceivedScan>);
static_assert(kGives<decltype(EstimatorEnds::graph.keyframes), Keyframe>);
static_assert(!kTakes<decltype(EstimatorEnds::graph.keyframes), Keyframe>);
static_assert(kTakes<decltype(GraphEnds::front_end.keyframes), Keyframe>);
static_assert(!kGives<decltype(GraphEnds::front_end.keyframes), Keyframe>);
static_assert(!kGives<decltype(EstimatorEnds::graph.corrections), MapCorrection*>);
static_assert(!kTakes<decltype(GraphEnds::front_end.corrections), MapCorrection*>);
static_assert(!kGives<decltype(BaseEnds::drives), DriveCommand>);
static_assert(!kTakes<decltype(BusEnds::commands.drives), DriveCommand>);
static_assert(!kGives<decltype(BusEnds::tiles.map), map_tile_t>);
// Nobody makes the keeper of all channels, or a queue, from an end.
static_assert(!std::is_constructible_v<SpscQueue<int>, Producer<int>>);

TEST(Channels, JoinTheEndsOfTheirThreads) {
  const auto channels = std::make_unique<Channels>();
  const EstimatorEnds estimator = channels->estimator();
  const GraphEnds graph = channels->graph();
  const BusEnds bus = channels->bus();
  WheelReading reading;
  reading.sample.T_wheels_base = {1.0, 2.0, 3.0};
  channels->base().wheels.push(reading);
  int arrived = 0;
  for (const auto& end : {estimator.samples.wheels, bus.raw.wheels})
    end.drain([&](const WheelReading& wheels) { arrived += wheels.sample.T_wheels_base == Pose2{1.0, 2.0, 3.0}; });
  EXPECT_EQ(arrived, 2) << "one to the estimator, one to the bus";
  bus.commands.set_poses.tryPush({{4.0, 5.0, 6.0}});
  EXPECT_TRUE(estimator.set_poses.popOne([](const SetPose& given) { EXPECT_EQ(given.T_map_base.x, 4.0); }));
  PoseSnapshot pose;
  pose.map_id = 7;
  estimator.pose_for_graph.store(pose);
  pose.map_id = 0;
  EXPECT_TRUE(graph.pose.load(pose));
  EXPECT_EQ(pose.map_id, 7);
  EXPECT_FALSE(channels->pose().pose.load(pose)) << "that one has a value of its own";
}

TEST(Channels, FreeWhatIsOnItsWayAtTheEnd) {  // seen by AddressSanitizer
  const auto channels = std::make_unique<Channels>();
  const GraphEnds graph = channels->graph();
  EXPECT_TRUE(graph.front_end.corrections.tryPush(new MapCorrection(ReferenceConfig{})));
  EXPECT_TRUE(graph.front_end.front_ends.tryPush(new FrontEnd(FrontEndConfig{}, nullptr)));
}

}  // namespace
}  // namespace slam::channels_test
