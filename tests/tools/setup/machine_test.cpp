// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/machine.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "tools/files.hpp"
#include "tools/sim/pseudo_terminal.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam::machine_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A root with two adapters. @return the folder of the names
void link(const fs::path& name, const fs::path& target) {
  fs::create_directories(name.parent_path());
  fs::create_symlink(target, name);
}

TEST(LastingName, IsByTheNumberOfTheAdapterOrByItsSocket) {
  const test::Folder root;
  fs::create_directories(root / "dev");
  const fs::path one = root.write("dev/ttyUSB0", ""), two = root.write("dev/ttyUSB1", ""),
                 three = root.write("dev/ttyS0", "");
  link(root / "dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00-port0", one);
  link(root / "dev/serial/by-path/pci-0-usb-0:1", one);
  link(root / "dev/serial/by-id/usb-FTDI_kobuki_AI02MRIC-if00-port0", two);
  link(root / "dev/serial/by-path/pci-0-usb-0:2", two);
  EXPECT_EQ(lastingName(one, root / ""), root / "dev/serial/by-path/pci-0-usb-0:1") << "many have the number 0001";
  EXPECT_EQ(lastingName(two, root / ""), root / "dev/serial/by-id/usb-FTDI_kobuki_AI02MRIC-if00-port0");
  EXPECT_EQ(lastingName(three, root / ""), three);
  EXPECT_TRUE(isSamePort(root / "dev/serial/by-path/pci-0-usb-0:2", two));
  EXPECT_FALSE(isSamePort(one, two));
  EXPECT_FALSE(isSamePort(root / "none", two));
}

TEST(SurveyMachine, NamesWhyAPortIsNotLookedAt) {
  const test::Folder folder;
  sim::PseudoTerminal locked(folder / "locked");
  const OpenedPort taken = openPort(folder / "locked", 115200);
  ASSERT_TRUE(taken.stream);
  std::ostringstream out;
  const Machine machine = surveyMachine({folder / "locked", folder / "none"}, true, out);
  ASSERT_EQ(machine.ports.size(), 2U);
  EXPECT_TRUE(machine.ports[0].finding.problem.is(problem::kPortInUse));
  EXPECT_TRUE(machine.ports[1].finding.problem.is(problem::kPortMissing));
  EXPECT_FALSE(machine.ports[1].finding.is_open);
  EXPECT_THAT(out.str(), HasSubstr("locked: the port is in use by another program"));
  EXPECT_THAT(out.str(), HasSubstr("Looking at 2 ports"));
}

}  // namespace
}  // namespace slam::machine_test
