// SPDX-License-Identifier: BSD-3-Clause
// The service as a robot has it: under a real systemd, with the rights of its unit, in a virtual machine.
#include "vm/robot.hpp"

#include <cstdlib>
#include <gtest/gtest.h>
#include <regex>

namespace slam::robot_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(VirtualRobot, IsInstalledDrivesAndComesBackWhateverHappensToTheService) {
  // Without hardware virtualisation it takes 5 minutes of a core, and more where others compute beside it.
  if (std::getenv("SLAMD_VIRTUAL_ROBOT") == nullptr) {
    GTEST_SKIP() << "takes long: tools/package && SLAMD_VIRTUAL_ROBOT=1 ctest --preset release -R VirtualRobot";
  }
  const std::string bin = SLAMD_BINARY_DIR;
  const fs::path folder = fs::path(testing::TempDir()) / ("robot_" + std::to_string(getpid()));
  fs::create_directories(folder);
  test::Robot robot;
  const int status = robot.prepare(folder);
  ASSERT_TRUE(status == 0 || status == test::Machine::kSkipped) << robot.problem();
  if (status == test::Machine::kSkipped || !robot.hasPackage()) {
    fs::remove_all(folder);
    GTEST_SKIP() << robot.problem();
  }
  ASSERT_TRUE(robot.choose("drive", {"--slamd", bin + "/..", bin + "/slam-sim", bin + "/vm_hold_thread"}))
      << robot.problem();
  const auto machine = robot.boot();
  EXPECT_EQ(machine->exitStatus(1100s), 0) << machine->report();
  const std::string console = machine->console();
  EXPECT_EQ(console.find("FAILED"), std::string::npos) << machine->report();
  // Those of the pose, and the supervisor; without graph or mapper the pose goes on, which the status judges.
  for (const char* thread : {"base", "lidar", "estimator", "pose", "bus", "slamd"}) {
    EXPECT_TRUE(std::regex_search(console, std::regex(std::string("thread ") + thread + ": [0-9]+ s until a pose")))
        << thread << "\n"
        << machine->report();
  }
  // Those that may wait for a disk.
  EXPECT_NE(console.find("threads of the disk held: disk space, log, log keeper, map, map files"), std::string::npos)
      << machine->report();
  if (!testing::Test::HasFailure()) fs::remove_all(folder);
}

}  // namespace
}  // namespace slam::robot_test
