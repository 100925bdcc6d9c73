// SPDX-License-Identifier: BSD-3-Clause
// What the tests on recorded data ask for, on simulated drives: these run in every clone.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "build_paths.hpp"
#include "config/loader.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/formats.hpp"
#include "tools/eval/metrics.hpp"
#include "tools/files.hpp"
#include "tools/replay/replay.hpp"
#include "tools/sim/log_mode.hpp"

namespace slam::replay_simulated_test {
namespace {

Config simulated(std::vector<std::string> settings = {}) {
  settings.insert(settings.begin(), {"lidar.driver='lcm'", "base.driver='lcm'", "imu.driver='lcm'"});
  return loadConfig(std::filesystem::path(SLAMD_SOURCE_DIR) / "config/sim.toml", settings);
}

/// Relations between true poses near each other in time and far apart, as people have drawn them up for intel.
std::vector<Relation> relationsOf(const Trajectory& truth) {
  std::vector<Relation> relations;
  for (const std::size_t apart : {std::size_t{50}, truth.size() / 3}) {
    for (std::size_t i = 0; i + apart < truth.size(); i += 40) {
      relations.push_back({truth[i].stamp, truth[i + apart].stamp, between(truth[i].pose, truth[i + apart].pose)});
    }
  }
  return relations;
}

class SimulatedReplay : public testing::Test {
 protected:
  void drive(const std::string& scene, std::uint64_t seed) {
    sim::writeLog({.scene = scene, .seed = seed, .truth = folder / "truth.tum"}, folder / "sound.lcm");
  }
  ReplayStats replayed(const Disturbance& disturbance, const std::vector<std::string>& settings = {}) {
    disturbLog(folder / "sound.lcm", folder / "drive.lcm", disturbance);
    ReplayOptions options;
    options.logs = {folder / "drive.lcm"};
    options.trajectory = folder / "slam.tum";
    return replay(simulated(settings), options);
  }
  RelationErrors errors() const {
    return relationErrors(readTrajectory(folder / "slam.tum"), relationsOf(readTrajectory(folder / "truth.tum")));
  }
  const test::Folder folder;
};

TEST_F(SimulatedReplay, WarnsOfWhatIsWrongAndOfNothingElse) {
  using testing::ElementsAre;
  using testing::HasSubstr;
  drive("meeting-room", 1);
  const auto warnings = [&](const Disturbance& disturbance) { return replayed(disturbance).warnings; };
  EXPECT_THAT(warnings({}), testing::IsEmpty());
  EXPECT_THAT(warnings({.lidar = {.upside_down = true}}),
              ElementsAre(HasSubstr("lidar turns opposite to gyro and wheels")));
  EXPECT_THAT(warnings({.lidar = {.turned = true}}), ElementsAre(HasSubstr("lidar.yaw")));
  EXPECT_THAT(warnings({.imu = {.down = true}}), ElementsAre(HasSubstr("the gyro turns opposite")));
  EXPECT_THAT(warnings({.wheels = {.swapped = true}}), ElementsAre(HasSubstr("left and right swapped")));
  EXPECT_THAT(warnings({.wheels = {.backwards = true}}), ElementsAre(HasSubstr("count backwards")));
  EXPECT_THAT(warnings({.double_scans = true}), ElementsAre(HasSubstr("repeat the one before")));
  EXPECT_THAT(warnings({.time_backwards = true}), ElementsAre(HasSubstr("stamped before the one before")));
  EXPECT_THAT(warnings({.wheels = {.distance_scale = 1.0}}), ElementsAre(HasSubstr("base.wheel_radius")));
}

TEST_F(SimulatedReplay, AFaultyGyroIsNamedAndDoesNoHarm) {
  using testing::ElementsAre;
  using testing::HasSubstr;
  drive("home", 1);
  const auto warnings = [&](const ImuFault& imu) {
    const ReplayStats stats = replayed({.imu = imu});
    const AteErrors error =
        absoluteErrors(readTrajectory(folder / "slam.tum"), readTrajectory(folder / "truth.tum"), false);
    EXPECT_LE(error.rmse, 0.02) << "[m]; measured 0.010 at most";
    return stats.warnings;
  };
  EXPECT_THAT(warnings({}), testing::IsEmpty());
  EXPECT_THAT(warnings({.step = 0.0174533}), testing::IsEmpty());
  EXPECT_THAT(warnings({.degrees = true}), ElementsAre(HasSubstr("the gyro reports 5")));
  EXPECT_THAT(warnings({.down = true}), ElementsAre(HasSubstr("the gyro turns opposite")));
  EXPECT_THAT(warnings({.clip = 0.5}), ElementsAre(HasSubstr("the gyro never reads more than 0.500 rad/s")));
  EXPECT_THAT(warnings({.offset = 0.4}), ElementsAre(HasSubstr("rad/s at rest; slamd takes that off")));
  EXPECT_THAT(warnings({.offset = 1.0}), ElementsAre(HasSubstr("too much for a bias; slamd goes on without it")));
}

/// The lidar sits 0.06 m ahead. The advice names the whole error, and followed it is the last one.
TEST_F(SimulatedReplay, GivesWhereTheLidarSitsAndTakesNoOtherErrorForIt) {
  using testing::ElementsAre;
  using testing::HasSubstr;
  drive("home", 2);
  const auto warnings = [&](const std::vector<std::string>& settings, const Disturbance& disturbance = {}) {
    return replayed(disturbance, settings).warnings;
  };
  EXPECT_THAT(warnings({"lidar.x=-0.004"}), ElementsAre(HasSubstr("add 0.06 m to lidar.x")));
  EXPECT_THAT(warnings({"lidar.x=0.066"}), testing::IsEmpty()) << "followed";
  EXPECT_THAT(warnings({"lidar.yaw=0.07"}), ElementsAre(HasSubstr("add -0.07 rad to lidar.yaw")));
  EXPECT_THAT(warnings({"lidar.time_offset=0.05"}), testing::IsEmpty());
  EXPECT_THAT(warnings({"lidar.time_offset=-0.08"}), testing::IsEmpty());
  EXPECT_THAT(warnings({}, {.wheels = {.distance_scale = 0.2}}), ElementsAre(HasSubstr("base.wheel_radius")));
  EXPECT_THAT(warnings({"lidar.x=-0.114", "imu.driver='none'"}), ElementsAre(HasSubstr("add 0.17 m to lidar.x")))
      << "scans and wheels agree on the turns";
}

TEST_F(SimulatedReplay, MeetsTheTrueRelations) {
  for (const std::uint64_t seed : {1, 2}) {
    drive("meeting-room", seed);
    replayed({});
    const RelationErrors found = errors();
    RecordProperty("translation_" + std::to_string(seed), std::to_string(found.translation.mean));
    RecordProperty("rotation_" + std::to_string(seed), std::to_string(found.rotation.mean));
    EXPECT_GE(found.used, 20);
    EXPECT_LE(found.translation.mean, 0.009) << "[m]; measured 0.0047 and 0.0040";
    EXPECT_LE(found.rotation.mean, 0.09) << "[deg]; measured 0.043 and 0.048";
  }
}

TEST_F(SimulatedReplay, IsNotLedAstrayByVeryNoisyWheels) {
  drive("meeting-room", 1);
  replayed({.wheels = {.noise = 0.4}, .seed = 1});
  const RelationErrors found = errors();
  RecordProperty("translation", std::to_string(found.translation.mean));
  RecordProperty("rotation", std::to_string(found.rotation.mean));
  EXPECT_LE(found.translation.mean, 0.02) << "[m]; measured 0.0105";
  EXPECT_LE(found.rotation.mean, 0.1) << "[deg]; measured 0.054";
}

}  // namespace
}  // namespace slam::replay_simulated_test
