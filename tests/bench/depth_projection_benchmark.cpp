// SPDX-License-Identifier: BSD-3-Clause
// What a depth image costs the depth thread: projection with the floor followed, of a furnished room.
#include <benchmark/benchmark.h>

#include "depth/depth_projection.hpp"
#include "tools/sim/depth/depth_camera.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam {
namespace {

void projectImage(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0));
  const sim::Scene scene = sim::makeScene("gazebo", 1);
  sim::DepthCamera camera(width, width * 3 / 4, 1);
  DepthProjectionConfig config;
  config.extrinsics = {.x = sim::DepthCamera::kExtrinsics.x, .z = sim::DepthCamera::kHeight};
  config.median = static_cast<int>(state.range(1));
  DepthProjection projection(config);
  DepthImage image;
  camera.capture(scene.world, {0.0, -3.0, -0.4}, 1, Timestamp{std::chrono::seconds(100)}, image);
  for (auto _ : state) benchmark::DoNotOptimize(projection.project(image));
}
BENCHMARK(projectImage)
    ->ArgNames({"width", "median"})
    ->Args({320, 1})
    ->Args({640, 1})
    ->Args({640, 3})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slam
