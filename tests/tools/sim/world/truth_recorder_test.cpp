// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/truth_recorder.hpp"

#include <gtest/gtest.h>
#include <numbers>

#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/robot/simulation.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim::truth_recorder_test {
namespace {

struct Cells {
  int occupied = 0, free = 0, unknown = 0;
};

Cells within(const MapImage& image, double x, double y, double length, double width) {
  Cells cells;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const double cx = image.origin_x + (column + 0.5) * image.resolution;
      const double cy = image.origin_y + (row + 0.5) * image.resolution;
      if (std::abs(cx - x) > length / 2 || std::abs(cy - y) > width / 2) continue;
      const std::uint8_t value = image.at(column, row);
      ++(value == MapImage::kOccupied ? cells.occupied : value == MapImage::kFree ? cells.free : cells.unknown);
    }
  }
  return cells;
}

TEST(TruthRecorder, TheGazeboDriveSeesEveryObstacleFromNear) {
  Scene scene = makeScene("gazebo", 1);
  LidarModel lidar(scene.world, {}, 1);
  TruthRecorder seen(scene.world, 1);
  Simulation simulation(scene, 1, Timestamp{});
  simulation.release();
  for (std::int64_t steps = 0; !simulation.finished(); ++steps) {
    simulation.step();
    const Pose2& pose = simulation.robot().pose();
    seen.addView(pose, simulation.now());
    if (steps % 40 != 0) continue;
    for (int i = 0; i < 360; ++i) {
      const double bearing = i * std::numbers::pi / 180.0;
      seen.addBeam(pose, bearing, lidar.trueRange(pose, bearing));
    }
  }
  const MapImage band = seen.bandMap(), plane = seen.lidarMap();
  struct Top {
    double x, y, length, width;
  };
  for (const Top& top :
       {Top{1.6, -1.5, 1.4, 0.7}, Top{3.6, -1.5, 0.9, 0.9}, Top{4.9, -4.6, 0.7, 1.4}, Top{6.1, -4.5, 0.8, 0.8}}) {
    const Cells cells = within(band, top.x, top.y, top.length, top.width);
    EXPECT_GT(cells.occupied, 0.9 * (cells.occupied + cells.unknown)) << top.x;
    EXPECT_EQ(cells.free, 0) << top.x;
    EXPECT_GT(within(plane, top.x, top.y, top.length, top.width).free, cells.occupied / 2) << top.x;
  }
  // The truck, askew: seen from around, so its outline is known, and nothing within.
  EXPECT_EQ(within(band, 1.9, -4.6, 1.8, 0.5).free, 0);
  EXPECT_GT(within(band, 1.9, -4.6, 2.4, 1.4).occupied, 100);
  const Cells aisle = within(band, 3.5, -3.0, 6.0, 0.6);
  EXPECT_EQ(aisle.occupied + aisle.unknown, 0);
}

}  // namespace
}  // namespace slam::sim::truth_recorder_test
