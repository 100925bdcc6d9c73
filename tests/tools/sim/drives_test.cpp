// SPDX-License-Identifier: BSD-3-Clause
// Whole simulated drives through the pipeline: the accuracy that must not get worse.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>

#include "build_paths.hpp"
#include "config/loader.hpp"
#include "mapping/map_files.hpp"
#include "tools/eval/metrics.hpp"
#include "tools/replay/replay.hpp"
#include "tools/sim/log_mode.hpp"
#include "tools/sim/robot/robot_model.hpp"

namespace slam::sim::drives_test {
namespace {

namespace fs = std::filesystem;

struct DriveFiles {
  fs::path folder = fs::path(testing::TempDir()) / ("drive_" + std::to_string(getpid()));
  fs::path log = folder / "log.lcm", truth = folder / "truth.tum", waypoints = folder / "way.tum";
  fs::path slam = folder / "slam.tum", odometry = folder / "odometry.tum", wheels = folder / "wheels.tum";

  DriveFiles() { fs::create_directories(folder); }
  ~DriveFiles() { fs::remove_all(folder); }

  ReplayStats drive(const std::string& scene, std::uint64_t seed, double seconds = 0.0) const {
    writeLog({.scene = scene, .seed = seed, .seconds = seconds, .truth = truth, .waypoints = waypoints}, log);
    const Config config = loadConfig(SLAMD_SIM_CONFIG, {"lidar.driver='lcm'", "base.driver='lcm'", "imu.driver='lcm'"});
    return replay(config, {.logs = {log}, .trajectory = slam, .odometry = odometry, .wheels = wheels});
  }
  WaypointErrors atWaypoints(const fs::path& trajectory) const {
    return waypointErrors(readTrajectory(trajectory), readTrajectory(waypoints));
  }
};

double mean(const std::vector<double>& values) { return meanAndDeviation(values).mean; }

TEST(SimulatedDrive, FusedOdometryIsFarBetterThanWheelsOnThePapersRectangle) {
  const DriveFiles files;
  double wheels = 0.0, fused = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    files.drive("tile-rectangle", seed);
    wheels += mean(files.atWaypoints(files.wheels).position);
    fused += mean(files.atWaypoints(files.odometry).position);
  }
  EXPECT_LT(fused, 0.17 * wheels);  // the paper: 0.67; measured here: 0.09
}

TEST(SimulatedDrive, SlamMeetsTheWaypointsOfTheMeetingRoom) {
  const DriveFiles files;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const ReplayStats stats = files.drive("meeting-room", seed);
    const WaypointErrors errors = files.atWaypoints(files.slam);
    ASSERT_EQ(errors.position.size(), 5U);
    for (const double metres : errors.position) EXPECT_LT(metres, 0.025) << "measured 0.013 at most";
    for (const double degrees : errors.heading) EXPECT_LT(degrees, 0.2) << "measured 0.11 at most";
    EXPECT_EQ(stats.front_end.unmatched, 0U);
  }
}

TEST(SimulatedDrive, SlamComesRoundTheCorridorLoop) {
  constexpr int kSeeds = 5;  // one drive's error is a matter of which place closes the loop first: 0.025 to 0.065 m
  double sum = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const DriveFiles files;
    files.drive("corridor-loop", seed);
    const AteErrors errors = absoluteErrors(readTrajectory(files.slam), readTrajectory(files.truth), false);
    EXPECT_GT(errors.used, 1000) << seed;
    sum += errors.rmse;
  }
  EXPECT_LT(sum / kSeeds, 0.05) << "[m]; measured 0.040, and 0.044 over 20 seeds";
}

/// Occupied cells where the scene's two persons walk and nothing else stands, in the map of a drive that ended then.
int cellsWhereThePersonsWalk(double seconds) {
  const DriveFiles files;
  const fs::path map = files.folder / "map";
  writeLog({.scene = "people", .seed = 1, .seconds = seconds, .depth = true, .truth = files.truth}, files.log);
  const Config config = loadConfig(SLAMD_SIM_CONFIG, {});
  replay(config, {.logs = {files.log}, .trajectory = files.slam, .map = map});
  const MapImage image = readMapFiles(map.string() + ".yaml");
  const Pose2 start = readTrajectory(files.truth).front().pose;  // the map begins there
  int occupied = 0;
  for (double x = 2.3; x < 3.7; x += image.resolution) {
    for (double y = -0.95; y < 1.15; y += image.resolution) {
      const Eigen::Vector2d p = start.inverse() * Eigen::Vector2d(x, y);
      occupied +=
          image.at(static_cast<int>(std::floor((p.x() - image.origin_x) / image.resolution)),
                   static_cast<int>(std::floor((p.y() - image.origin_y) / image.resolution))) == MapImage::kOccupied;
    }
  }
  return occupied;
}

TEST(SimulatedDrive, NothingIsLeftOfAPersonTenSecondsAfterTheyHaveGone) {
  constexpr double kGone = 26.0;  // [s] both walked through the view for 20 s
  EXPECT_GT(cellsWhereThePersonsWalk(kGone - 2.0), 0);
  EXPECT_EQ(cellsWhereThePersonsWalk(kGone + 10.0), 0);
}

TEST(SimulatedDrive, OfOneSeedIsTheSameToTheByte) {
  const DriveFiles a;
  const auto bytes = [](const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  a.drive("meeting-room", 5, 20.0);
  const std::string log = bytes(a.log), slam = bytes(a.slam);
  a.drive("meeting-room", 5, 20.0);
  EXPECT_EQ(log, bytes(a.log));
  EXPECT_EQ(slam, bytes(a.slam));
  a.drive("meeting-room", 6, 20.0);
  EXPECT_NE(log, bytes(a.log));
}

TEST(RobotModel, CountsEncoderTicksAndSlips) {
  RobotModel robot({}, 3);
  for (int i = 0; i < 60 * 200; ++i) robot.step({0.2, 0.0, 0.0}, 0.005);
  const auto angles = robot.encoderAngles();
  constexpr double kCount = 2.0 * 3.14159265358979323846 / kCountsPerTurn;
  for (const double angle : angles) EXPECT_NEAR(angle / kCount, std::round(angle / kCount), 1e-6);
  EXPECT_GT(robot.slips(), 0);
  EXPECT_NEAR(robot.pose().x, 12.0, 1e-6);
  EXPECT_NEAR(angles[0] * kNominalBase.wheel_radius, 12.0, 0.6);  // radius errors and slip
}

}  // namespace
}  // namespace slam::sim::drives_test
