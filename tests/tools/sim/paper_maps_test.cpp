// SPDX-License-Identifier: BSD-3-Clause
// The maps of the paper's Fig. 8 and Fig. 12 from simulated drives: by the lidar alone, and fused with the depth camera
// in both ways. `tools/paper` prints the figures of more seeds.
#include <gtest/gtest.h>
#include <ostream>
#include <string>
#include <vector>

#include "build_paths.hpp"
#include "config/loader.hpp"
#include "mapping/map_files.hpp"
#include "tools/eval/map_metrics.hpp"
#include "tools/files.hpp"
#include "tools/replay/replay.hpp"
#include "tools/sim/log_mode.hpp"

namespace slam::paper_maps_test {
namespace {

/// Bounds of one map: less than twice what is measured with seed 1. All in [1].
struct Bounds {
  double missed_precision, missed_recall, false_obstacles;
};
struct Figure {
  const char* scene;
  double lidar_recall;  ///< of all obstacles in the robot's height band: the lidar sees a plane
  Bounds paper, layers;
};
void PrintTo(const Figure& figure, std::ostream* out) { *out << figure.scene; }

class PaperMaps : public testing::TestWithParam<Figure> {
 protected:
  void SetUp() override {
    sim::SimOptions options;
    options.scene = GetParam().scene;
    options.depth = true;
    options.truth_map = folder / "truth";
    sim::writeLog(options, folder / "drive.lcm");
    truth = readMapFiles(folder / "truth.yaml");
  }
  MapErrors errorsOf(const std::vector<std::string>& settings) const {
    const Config config = loadConfig(SLAMD_SIM_CONFIG, settings);
    ReplayOptions options;
    options.logs = {folder / "drive.lcm"};
    options.map = folder / "map";
    replay(config, options);
    return compareMaps(readMapFiles(folder / "map.yaml"), truth);
  }
  static void expectWithin(const MapErrors& errors, const Bounds& bounds) {
    EXPECT_LT(1.0 - errors.occupied.precision, bounds.missed_precision);
    EXPECT_LT(1.0 - errors.occupied.recall, bounds.missed_recall);
    EXPECT_LT(errors.false_obstacles, bounds.false_obstacles);
    EXPECT_GT(errors.completeness, 0.99);
    EXPECT_GT(errors.free.precision, 0.987);
    EXPECT_GT(errors.free.recall, 0.95);
  }
  test::Folder folder;
  MapImage truth;
};

TEST_P(PaperMaps, ShowByFusionWhatTheLidarCannotSee) {
  const MapErrors lidar = errorsOf({"depth.driver='none'"});
  const MapErrors paper = errorsOf({"map.fusion='paper'"});
  const MapErrors layers = errorsOf({"map.fusion='layers'"});
  EXPECT_NEAR(lidar.occupied.recall, GetParam().lidar_recall, 0.03);
  EXPECT_GT(lidar.occupied.precision, 0.999);
  EXPECT_LT(lidar.false_obstacles, 0.0001);
  {
    SCOPED_TRACE("paper");
    expectWithin(paper, GetParam().paper);
  }
  SCOPED_TRACE("layers");
  expectWithin(layers, GetParam().layers);
  EXPECT_LT(layers.false_obstacles, 0.5 * paper.false_obstacles) << "later looks take back what earlier ones said";
  EXPECT_GT(paper.occupied.recall, layers.occupied.recall) << "and the paper's fusion nothing";
}

INSTANTIATE_TEST_SUITE_P(
    Of, PaperMaps,
    testing::Values(Figure{"gazebo", 0.524, {0.020, 0.027, 0.0030}, {0.0065, 0.028, 0.0009}},
                    Figure{"meeting-room", 0.599, {0.022, 0.007, 0.0035}, {0.0026, 0.013, 0.0004}}),
    [](const auto& figure) { return std::string(figure.param.scene) == "gazebo" ? "Fig8" : "Fig12"; });

}  // namespace
}  // namespace slam::paper_maps_test
