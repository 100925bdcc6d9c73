// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/proposal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "config/config_values.hpp"
#include "config/file_edit.hpp"
#include "config/loader.hpp"
#include "tools/files.hpp"
#include "tools/slamctl/setup/terminal_console.hpp"

namespace slam::proposal_test {
namespace {

using testing::HasSubstr;
using testing::Not;

FoundPort port(const std::string& path, PortFinding::Kind kind, const std::string& driver, int baud,
               bool usual = true) {
  return {.path = path,
          .finding = {.kind = kind, .driver = driver, .name = "a " + driver, .baud = baud, .is_usual_baud = usual}};
}
const FoundPort kA1 = port("/x/a1", PortFinding::kLidar, "rplidar", 115200),
                kC1 = port("/x/c1", PortFinding::kLidar, "rplidar", 460800, false),
                kLd06 = port("/x/ld06", PortFinding::kLidar, "ld06", 230400),
                kKobuki = port("/x/kobuki", PortFinding::kBase, "kobuki", 115200),
                kText = port("/x/text", PortFinding::kBase, "text", 115200, false),
                kBoard = port("/x/board", PortFinding::kBase, "handsfree", 921600),
                kWit = port("/x/wit", PortFinding::kImu, "witmotion", 9600);

struct Proposed {
  Config config;
  std::string words;
};
/// @param typed nullptr: nobody can be asked
Proposed propose(
    const Machine& machine, const char* typed, const std::string& file = "",
    const std::function<Machine()>& again = [] { return Machine(); }) {
  Config config;
  const auto set = setFrom(file, "file", config);
  std::istringstream in(typed == nullptr ? "" : typed);
  std::ostringstream out;
  TerminalConsole console(typed == nullptr ? nullptr : &in, out);
  Interview interview(config, set, console);
  proposeDevices(interview, machine, again);
  EXPECT_THAT(test::differences(parseConfig(editedConfig("", interview.config()), "written"), interview.config()),
              testing::IsEmpty());
  return {interview.config(), out.str()};
}

TEST(Proposal, TakesWhatIsPluggedInInAnyOrder) {
  for (const Machine& machine : {Machine{.ports = {kKobuki, kC1}}, Machine{.ports = {kC1, kKobuki}}}) {
    const Config config = propose(machine, nullptr).config;
    EXPECT_EQ(config.lidar_device.driver, LidarDriver::kRplidar);
    EXPECT_EQ(config.lidar_device.port, "/x/c1");
    EXPECT_EQ(config.lidar_device.baud, 460800);
    EXPECT_EQ(config.base_device.driver, BaseDriver::kKobuki);
    EXPECT_EQ(config.base_device.baud, 0);
    EXPECT_NEAR(config.base_device.geometry.wheel_radius, 0.035, 0.001) << "its maker's";
    EXPECT_EQ(config.imu_device.driver, ImuDriver::kBase);
    EXPECT_EQ(config.depth_device.driver, DepthDriver::kNone) << "no camera is plugged in";
  }
}

TEST(Proposal, AsksForWhatNoPortAnswersWithADrawingOfTheAxes) {
  const Proposed proposed = propose({.ports = {kA1, kText, kWit}, .camera = true},
                                    "1440\n0.03\n0.1\n\n0.12\n0.0\n1.5708\nfalse\n0.2\n0.5\n0.3\n");
  const Config& config = proposed.config;
  EXPECT_EQ(config.base_device.baud, 115200);
  EXPECT_EQ(config.base_device.counts_per_turn, 1440.0);
  EXPECT_EQ(config.base_device.geometry.half_track, 0.1);
  EXPECT_EQ(config.imu_device.driver, ImuDriver::kWitmotion);
  EXPECT_EQ(config.imu_device.baud, 0) << "its driver finds it";
  EXPECT_EQ(config.front_end.lidar.T_base_lidar.theta, 1.5708);
  EXPECT_EQ(config.depth_device.projection.extrinsics.z, 0.5);
  EXPECT_THAT(proposed.words, HasSubstr("x, forward"));
}

TEST(Proposal, KeepsWhatIsRightAndAsksNothingTwice) {
  const std::string file =
      "[lidar]\ndriver = 'ld19'\nport = '/x/ld06'\nbaud = 230400\nx = 0.1\ny = 0.0\nyaw = 0.0\nupside_down = false\n"
      "[base]\ndriver = 'kobuki'\nport = '/x/kobuki'\nwheel_radius = 0.0352\nhalf_track = 0.116\n"
      "[imu]\ndriver = 'none'\n[depth]\ndriver = 'none'\n";
  const Proposed proposed = propose({.ports = {kLd06, kKobuki}}, "", file);
  EXPECT_THAT(test::differences(proposed.config, parseConfig(file, "file")), testing::IsEmpty());
  EXPECT_EQ(proposed.words, "");
}

TEST(Proposal, FollowsADeviceToAnotherPort) {
  const Config config = propose({.ports = {kA1, kBoard}}, nullptr, "lidar.port = '/x/elsewhere'\nlidar.x = 0.3").config;
  EXPECT_EQ(config.lidar_device.port, "/x/a1");
  EXPECT_EQ(config.front_end.lidar.T_base_lidar.x, 0.3);
  EXPECT_EQ(config.imu_device.driver, ImuDriver::kHandsfree);
}

TEST(Proposal, AsksWhichOfTwoOfOneKind) {
  EXPECT_EQ(propose({.ports = {kA1, kC1}}, "2\n").config.lidar_device.port, "/x/c1");
  EXPECT_EQ(propose({.ports = {kA1, kC1}}, "7\n1\n", "",
                    [] {
                      return Machine{.ports = {kA1, kC1}};
                    })
                .config.lidar_device.port,
            "/x/a1");
  int looks = 0;
  const auto unplugged = [&] { return ++looks, Machine{.ports = {kC1}}; };
  EXPECT_EQ(propose({.ports = {kA1, kC1}}, "\n", "", unplugged).config.lidar_device.port, "/x/c1");
  EXPECT_EQ(looks, 1);
  EXPECT_EQ(propose({.ports = {kA1, kC1}}, nullptr, "lidar.port = '/x/c1'").config.lidar_device.port, "/x/c1");
  const std::string refusal = test::refusalOf([] { propose({.ports = {kA1, kC1}}, nullptr); });
  EXPECT_THAT(refusal, HasSubstr("set lidar.port in the answers"));
  EXPECT_THAT(refusal, HasSubstr("/x/c1"));
  EXPECT_NE(test::refusalOf([] { propose({.ports = {kA1, kC1}}, ""); }), "") << "the terminal has gone";
}

TEST(Proposal, TakesODrivesByTheirHeartbeats) {
  const Machine machine{.ports = {kA1}, .buses = {{"can1", {3, 4}}}};
  const Config config = propose(machine, "4\n3\n0.05\n0.2\n").config;
  EXPECT_EQ(config.base_device.driver, BaseDriver::kCan);
  EXPECT_EQ(config.can.interface, "can1");
  EXPECT_EQ(config.can.left_node, 4);
  EXPECT_EQ(config.can.right_node, 3);
  const Config usual = propose({.ports = {}, .buses = {{"can0", {16, 24}}}}, nullptr).config;
  EXPECT_EQ(usual.can.left_node, 16) << "as ODrives of this kind of robot have it";
}

TEST(Proposal, TakesVescsByTheirStatusAndByTheirPort) {
  const Machine machine{.ports = {kA1}, .buses = {{.interface = "can1", .vescs = {3, 120}}}};
  const Config config = propose(machine, "7\n120\n3\n0.05\n0.2\n").config;
  EXPECT_EQ(config.base_device.driver, BaseDriver::kCan);
  EXPECT_EQ(config.can.protocol, can::Protocol::kVesc);
  EXPECT_EQ(config.can.pole_pairs, 7);
  EXPECT_EQ(config.can.left_node, 120);
  EXPECT_EQ(config.can.right_node, 3);
  const FoundPort port{.path = "/x/vesc", .finding = {.kind = PortFinding::kBase, .driver = "vesc", .baud = 115200}};
  const Config serial = propose({.ports = {kA1, port}}, "42\n5\n6\n0.05\n0.2\n").config;
  EXPECT_EQ(serial.base_device.driver, BaseDriver::kVesc);
  EXPECT_EQ(serial.base_device.counts_per_turn, 42.0);
  EXPECT_EQ(serial.can.left_node, 5);
  EXPECT_EQ(serial.can.right_node, 6);
}

TEST(Proposal, ReportsWhatIsMissingAndKeepsAnotherProgramsSensors) {
  const Config none = propose({}, nullptr).config;
  EXPECT_EQ(none.base_device.driver, BaseDriver::kNone);
  EXPECT_EQ(none.imu_device.driver, ImuDriver::kNone);
  const Config lcm = propose({}, nullptr, "base.driver = 'lcm'\nimu.driver = 'lcm'\nlidar.driver = 'lcm'").config;
  EXPECT_EQ(lcm.base_device.driver, BaseDriver::kLcm);
  EXPECT_EQ(lcm.imu_device.driver, ImuDriver::kLcm);
  const Config chip = propose({.ports = {}, .chips = {"mpu6050"}}, nullptr).config;
  EXPECT_EQ(chip.imu_device.driver, ImuDriver::kIio);
  EXPECT_EQ(chip.imu_device.port, "mpu6050");
}

}  // namespace
}  // namespace slam::proposal_test
