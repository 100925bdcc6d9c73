// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/log_truth.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <unistd.h>

#include "build_paths.hpp"
#include "config/loader.hpp"
#include "store/map_store.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/replay/replay.hpp"
#include "tools/sim/log_mode.hpp"

namespace slam::log_truth_test {
namespace {

namespace fs = std::filesystem;

/// A map that one drive through the meeting room made, and the log of another drive with errors of its own.
class LogTruthTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = fs::path(testing::TempDir()) / ("log_truth_" + std::to_string(getpid()));
    fs::create_directories(folder);
    config = loadConfig(SLAMD_SIM_CONFIG, {"lidar.driver='lcm'", "base.driver='lcm'", "imu.driver='lcm'"});
    for (const std::uint64_t seed : {1, 2}) {
      const std::string name = std::to_string(seed);
      sim::writeLog({.scene = "meeting-room", .seed = seed, .truth = folder / (name + ".tum")},
                    folder / (name + ".lcm"));
    }
    replay(config, {.logs = {folder / "1.lcm"}, .save_map = folder / "map"});
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  static MapState map() { return openMap(folder / "map", config.map).state; }
  /// The map, were all its ways longer.
  static MapState stretched(double scale) {
    MapState map = LogTruthTest::map();
    KeyframeGraph longer;
    for (int id = 0; id < map.keyframes.size(); ++id) {
      auto scan = std::make_shared<StoredScan>(*map.keyframes.scan(id));
      for (Keyframe::Point& point : scan->points) {
        point.x *= static_cast<float>(scale);
        point.y *= static_cast<float>(scale);
      }
      const Pose2& pose = map.keyframes.pose(id);
      longer.add(std::move(scan), {scale * pose.x, scale * pose.y, pose.theta});
    }
    map.keyframes = std::move(longer);
    return map;
  }
  /// Largest distance of a row from where the robot was [m]. @param scale of the map
  static double worst(const LogTruth& fitted, double scale) {
    const Trajectory first = readTrajectory(folder / "1.tum"), second = readTrajectory(folder / "2.tum");
    double largest = 0.0;
    for (const LogTruth::Row& row : fitted.rows) {
      const std::optional<Pose2> at = poseAt(second, row.stamp);
      if (!at) continue;
      const Pose2 truth = between(first.front().pose, *at);  // the map begins where the first drive did
      largest = std::max(largest, (row.T_map_base.translation() - scale * truth.translation()).norm());
      ++compared;
    }
    return largest;
  }

  static inline fs::path folder;
  static inline Config config;
  static inline int compared = 0;
};

TEST_F(LogTruthTest, PutsEachScanWhereTheRobotWas) {
  const LogTruth fitted = fitLog(readSamples(folder / "2.lcm"), config, map());
  EXPECT_LT(worst(fitted, 1.0), 0.12);
  EXPECT_GT(compared, 100);
  EXPECT_GT(fitted.seen, 0.9);
  EXPECT_GT(fitted.margin, 50.0);
}

TEST_F(LogTruthTest, BendsIntoAMapThatIsLongerOrShorterThanTheLog) {
  for (const double scale : {0.97, 1.03}) {
    const LogTruth fitted = fitLog(readSamples(folder / "2.lcm"), config, stretched(scale));
    EXPECT_LT(worst(fitted, scale), 0.15) << scale;
    EXPECT_GT(fitted.seen, 0.9) << scale;
  }
}

TEST_F(LogTruthTest, RefusesALogWithoutScans) { EXPECT_THROW(fitLog({}, config, map()), std::runtime_error); }

}  // namespace
}  // namespace slam::log_truth_test
