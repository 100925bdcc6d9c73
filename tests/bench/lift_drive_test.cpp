// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/lift_drive.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <unistd.h>

#include "store/map_store.hpp"
#include "tools/bench/log_truth.hpp"
#include "tools/sim/log_mode.hpp"

namespace slam::lift_drive_test {
namespace {

namespace fs = std::filesystem;

constexpr double kBegin = 1.7e9;  // [s] of each simulated log

/// Two floors of a home, with the same walls and one landing, and their maps.
class LiftDrive : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fs::create_directories(folder());
    for (const int floor : {1, 2}) {
      simulate(1, floor, 0);
      const Config config;
      Pipeline pipeline({frontEndConfig(config), backEndConfig(config), config.map});
      for (const LogSample& sample : readSamples(log())) addTo(pipeline, sample);
      MapState map = pipeline.state();
      map.utime = 1;
      MapStore(folder(), name(floor)).checkpoint(map);
    }
  }
  static void TearDownTestSuite() { fs::remove_all(folder()); }

  static fs::path folder() { return fs::path(testing::TempDir()) / ("lift_drive_test_" + std::to_string(getpid())); }
  static fs::path log() { return folder() / "drive.lcm"; }
  static std::string name(int floor) { return "floor-" + std::to_string(floor); }
  static void simulate(std::uint64_t seed, int floor, int lift) {
    sim::SimOptions options{.scene = "homes", .seed = seed};
    options.depth = false;
    options.situation.scene.floor = floor;
    options.situation.scene.lift = lift;
    options.waypoints = folder() / "waypoints.tum";
    sim::writeLog(options, log());
  }
  /// @return [s] since the log's begin, when the robot leaves the cabin
  static double departure() {
    std::ifstream rows(folder() / "waypoints.tum");
    std::string row;
    for (int i = 0; i < 3; ++i) std::getline(rows, row);
    return std::stod(row) - kBegin;
  }
};

TEST_F(LiftDrive, IsNoticedAndEndsInTheOtherFloorsMapWithoutBeingSureOfAWrongOne) {
  for (const int to : {2, 1}) {
    simulate(9, 1, to);
    const auto report =
        driveWithLift(log(), folder(), Config{}, {.begin_in = name(1), .arrive_in = name(to), .departs = departure()});
    EXPECT_TRUE(report.was_sure);
    EXPECT_EQ(report.doubts, 1) << "and the floor that it was on may be the one that it comes to";
    EXPECT_EQ(report.wrong_and_sure, 0.0);
    EXPECT_LT(report.known, 20.0);
    EXPECT_LT(report.driven, 6.0);
    EXPECT_EQ(report.ends_in, name(to));
    EXPECT_TRUE(report.ends_sure);
    EXPECT_EQ(report.lost, 1) << "at the start alone: its pose goes on";
  }
}

TEST_F(LiftDrive, HasNoneWhereTheRobotLooksIntoALiftThatStaysOpen) {
  simulate(17, 1, 0);
  const auto report = driveWithLift(log(), folder(), Config{}, {.begin_in = name(1), .arrive_in = {}});
  EXPECT_TRUE(report.was_sure);
  EXPECT_EQ(report.doubts, 0);
  EXPECT_EQ(report.wrong_and_sure, 0.0);
  EXPECT_EQ(report.ends_in, name(1));
}

TEST_F(LiftDrive, NeedsALogWithScansAndMaps) {
  std::ofstream(log()).close();
  EXPECT_THROW(driveWithLift(log(), folder(), Config{}, {.begin_in = name(1), .arrive_in = {}}), std::runtime_error);
  EXPECT_THROW(driveWithLift(log(), folder(), Config{}, {.begin_in = "attic", .arrive_in = {}}), std::runtime_error);
}

}  // namespace
}  // namespace slam::lift_drive_test
