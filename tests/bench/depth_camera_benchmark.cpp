// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "tools/sim/depth/depth_camera.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim {
namespace {

struct Place {
  const char* scene;
  Pose2 pose;
  double time;  // [s]
};
constexpr Place kPlaces[] = {
    {"gazebo", {0.0, -3.0, -0.3}, 0.0}, {"people", {0.3, 0.0, 0.0}, 12.0}, {"meeting-room", {0.0, -6.0, 0.5}, 0.0}};

/// One image of the camera: argument 0 the place, 1 the width [px].
void captureDepth(benchmark::State& state) {
  const Place& place = kPlaces[state.range(0)];
  const int width = static_cast<int>(state.range(1));
  World world = makeScene(place.scene, 1).world;
  world.setTime(place.time);
  DepthCamera camera(width, width * 3 / 4, 1);
  DepthImage image;
  std::uint64_t frame = 0;
  for (auto _ : state) camera.capture(world, place.pose, frame++, {}, image);
  state.SetLabel(place.scene);
}
BENCHMARK(captureDepth)
    ->Name("depth image with errors")
    ->ArgsProduct({{0, 1, 2}, {320, 640}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slam::sim
