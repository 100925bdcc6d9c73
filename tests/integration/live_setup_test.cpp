// SPDX-License-Identifier: BSD-3-Clause
// slamctl setup as a user runs it, with emulated devices that are understood at their own baud rate alone.
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <numbers>

#include "config/loader.hpp"
#include "drivers/base/base_facts.hpp"
#include "drivers/lidar/lidar_facts.hpp"
#include "integration/live.hpp"
#include "tools/sim/base/emulated_base.hpp"
#include "tools/sim/lidar/lidar_identity.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/lidar/packet_encoders.hpp"
#include "tools/sim/robot/robot_model.hpp"

namespace slam::live_setup_test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

/// What is expected of a lidar: its driver, and its rate [bit/s]; 0: any.
struct Expected {
  std::string driver;
  int baud = 0;
};
Expected lidarOf(const std::string& name) {
  const std::string model(sim::lidarModel(name));
  for (const sim::NamedIdentity& unit : sim::namedIdentities()) {
    if (model == unit.name) return {"rplidar", unit.make().baud};
  }
  if (const LidarFacts* facts = findLidar(model)) return {facts->driver, facts->baud};
  return {"hokuyo", 0};
}

class LiveSetup : public test::Live {
 protected:
  void startDevices(const std::string& lidar, const std::string& base) {
    const BaseFacts* facts = findBase(base);
    std::ofstream(folder_ / "faults") << "0 lidar baud " << lidarOf(lidar).baud << "\n0 board baud "
                                      << (facts == nullptr ? 921600 : facts->baud) << "\n";
    // Through doors and both ways around corners: what a calibration wants to see.
    startSimulator("600", "home", {"--speed", "0.4", "--lidar", lidar, "--base", base, "--faults", folder_ / "faults"});
  }
  fs::path file() const { return folder_ / "slamd.toml"; }
  /// @return exit code
  int setUp(const std::string& answers, const std::vector<std::string>& options) {
    std::ofstream(folder_ / "answers") << "runtime.socket = " << (folder_ / "socket").string() << "\n"
                                       << (test::kSanitized ? "runtime.realtime = false\n" : "") << answers;
    std::vector<std::string> command{test::kBin + "/slamctl", "--config", file(), "setup", "--answers",
                                     folder_ / "answers"};
    command.insert(command.end(), options.begin(), options.end());
    test::Process setup(command, folder_ / "setup.txt");
    return setup.wait(test::kPatience * 150s).value_or(-1);
  }
  std::string words() const { return textOf(folder_ / "setup.txt"); }
  std::string device(const char* name) const { return folder_ / "devices" / name; }
};

/// A few pairs, or with SLAMD_ALL_PAIRS=1 all of them, or with the word of a lidar or a base all of its own.
TEST_F(LiveSetup, FindsPairsOfLidarAndBaseInAnyOrder) {
  std::vector<std::pair<std::string, std::string>> pairs = {{"c1", "text"},           {"ld19", "create"},
                                                            {"ydlidar-x4", "kobuki"}, {"hokuyo-urg", "handsfree"},
                                                            {"coin-d4", "vesc"},      {"lds01", "roboclaw"}};
  if (const char* wanted = std::getenv("SLAMD_ALL_PAIRS")) {
    const std::string_view word(wanted);
    pairs.clear();
    for (const std::string& lidar : sim::lidarNames()) {
      if (std::string(sim::lidarModel(lidar)).starts_with("sick")) continue;  // it is on the network
      for (const std::string& base : sim::baseNames())
        if (word == "1" || word == lidar || word == base) pairs.emplace_back(lidar, base);
    }
  }
  int right = 0;
  bool swap = false;
  for (const auto& [lidar, base] : pairs) {
    SCOPED_TRACE(lidar + ", " + base);
    startDevices(lidar, base);
    swap = !swap;
    const std::string first = device(swap ? "board" : "lidar"), second = device(swap ? "lidar" : "board");
    fs::remove(file());
    const int code =
        setUp("base.counts_per_turn = 1440\n", {"--yes", "--drive", "0", "--port", first, "--port", second});
    ASSERT_TRUE(fs::exists(file())) << words();
    const Config config = loadConfig(file());
    const Expected expected = lidarOf(lidar);
    const std::string driver = wordOf(config.lidar_device.driver);
    const LidarFacts *found = findLidar(driver), *facts = findLidar(expected.driver);
    const bool alike = found != nullptr && facts != nullptr && found->packets == facts->packets &&
                       found->baud == facts->baud && found->sample_rate == facts->sample_rate;
    const bool good =
        code == 0 && (driver == expected.driver || alike) && config.lidar_device.port == device("lidar") &&
        config.base_device.port == device("board") && wordOf(config.base_device.driver) == base &&
        (expected.driver != "rplidar" || expected.baud == 115200 || config.lidar_device.baud == expected.baud);
    EXPECT_TRUE(good) << code << "\n" << words();
    right += good ? 1 : 0;
    sim_.reset();
    fs::remove_all(folder_ / "devices");
  }
  std::printf("%d of %zu pairs of lidar and base were found\n", right, pairs.size());
}

TEST_F(LiveSetup, CalibratesWhatIsOffAndKeepsItTheSecondTime) {
  if (test::kSanitized) GTEST_SKIP() << "skipped: with sanitizers the devices are not played in real time";
  const sim::TrueBase truth = sim::RobotModel({}, 1).trueBase();
  const double radius = 0.5 * (truth.left_radius + truth.right_radius);
  const Pose2 mount = sim::LidarModel::kExtrinsics;
  startDevices("rplidar", "handsfree");
  const std::string off = "[base]\nwheel_radius = " + std::to_string(1.05 * radius) +
                          "  # by ruler\nhalf_track = " + std::to_string(0.95 * truth.half_track) +
                          "\n[lidar]\nx = " + std::to_string(mount.x + 0.06) + "\ny = 0.0\nyaw = 0.07\n";
  std::ofstream(file()) << off;
  const std::vector<std::string> options{"--yes",         "--drive", "60",           "--port",
                                         device("lidar"), "--port",  device("board")};
  ASSERT_EQ(setUp("", options), 0) << words();
  std::printf("%s\n", words().c_str());
  const Config config = loadConfig(file());
  EXPECT_NEAR(config.base_device.geometry.wheel_radius, radius, 0.005 * radius);
  EXPECT_NEAR(config.base_device.geometry.half_track, truth.half_track, 0.005 * truth.half_track);
  const Pose2 error = between(mount, config.front_end.lidar.T_base_lidar);
  EXPECT_LT(error.translation().norm(), 0.01);
  EXPECT_LT(std::abs(error.theta), std::numbers::pi / 180.0);
  EXPECT_NE(textOf(file()).find("# by ruler"), std::string::npos) << "a builder's comments stay";
  EXPECT_EQ(textOf(file().string() + ".old"), off);

  const std::string written = textOf(file());
  EXPECT_EQ(setUp("", {"--yes", "--drive", "0", "--port", device("lidar"), "--port", device("board")}), 0) << words();
  EXPECT_EQ(textOf(file()), written);
  EXPECT_NE(words().find("Nothing is to be changed"), std::string::npos) << words();
}

TEST_F(LiveSetup, RefusesAnUnknownAnswerAndNamesALidarThatIsMissing) {
  startDevices("rplidar", "kobuki");
  EXPECT_EQ(setUp("lidar.prot = /dev/x\n", {"--yes", "--port", device("board")}), 78);
  EXPECT_NE(words().find("did you mean 'port'?"), std::string::npos) << words();
  EXPECT_FALSE(fs::exists(file()));
  EXPECT_EQ(setUp("", {"--yes", "--drive", "0", "--port", device("board")}), 1) << words();
  EXPECT_NE(words().find("FAULT    lidar: no port /dev/rplidar"), std::string::npos) << words();
  EXPECT_EQ(wordOf(loadConfig(file()).base_device.driver), std::string("kobuki"));
}

}  // namespace
}  // namespace slam::live_setup_test
