// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/open_problem.hpp"

#include <cerrno>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::open_problem_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(OpenProblem, NameTheGroupThatIsMissing) {
  EXPECT_THAT(openProblem(EACCES, {"/dev/ttyUSB0", "dialout", true, false}).words(),
              AllOf(HasSubstr("EACCES"), HasSubstr("belongs to group dialout"), HasSubstr("usermod -aG dialout $USER"),
                    HasSubstr("SupplementaryGroups=dialout")));
  EXPECT_THAT(openProblem(EACCES, {"/dev/ttyUSB0", "plugdev", true, false}).words(), HasSubstr("usermod -aG plugdev"));
  EXPECT_THAT(openProblem(EACCES, {"/dev/ttyUSB0", "root", true, false}).words(), HasSubstr("udev rules"));
  EXPECT_THAT(openProblem(EACCES, {"/dev/ttyUSB0", "dialout", false, true}).words(), HasSubstr("udev rules"));
  EXPECT_THAT(openProblem(EACCES, {"/dev/ttyUSB0", "dialout", true, true}).words(), HasSubstr("security module"));
}

TEST(OpenProblem, NameNoRuleOfSlamdForAPortThatIsNoUsbAdapters) {
  for (const bool group_may : {false, true}) {
    const NodeRights on_board{"/dev/serial0", group_may ? "root" : "tty", group_may,
                              false,          /*on_usb=*/false,           "ttyAMA0"};
    EXPECT_THAT(openProblem(EACCES, on_board).words(),
                AllOf(HasSubstr("belongs to group " + on_board.group), HasSubstr("serial-getty@ttyAMA0"),
                      HasSubstr("KERNEL==\"ttyAMA0\", GROUP=\"dialout\""),
                      testing::Not(HasSubstr("install slamd's udev rules"))));
  }
}

TEST(OpenProblem, DistinguishASandboxFromAMissingRight) {
  EXPECT_THAT(openProblem(EPERM, {"/dev/ttyX0", "dialout", true, true}).words(),
              AllOf(HasSubstr("EPERM"), HasSubstr("DeviceAllow=/dev/ttyX0 rw"), HasSubstr("docker run --device")));
}

TEST(OpenProblem, NameTheReasonOfAnyOtherError) {
  EXPECT_THAT(openProblem(ENOENT, {}).words(), HasSubstr("no such port"));
  EXPECT_THAT(openProblem(EMFILE, {}).words(), HasSubstr("no file descriptors are left"));
  EXPECT_THAT(openProblem(EIO, {}).words(), HasSubstr("EIO"));
  EXPECT_THAT(openProblem(EINVAL, {}).words(), HasSubstr("Invalid argument"));
}

TEST(OpenProblem, NamesTheRightsOfANode) {
  const NodeRights rights = rightsOf("/dev/null");
  EXPECT_EQ(rights.group, "root");
  EXPECT_TRUE(rights.group_may);
  EXPECT_FALSE(rights.on_usb);
  EXPECT_EQ(rights.tty, "null");
  EXPECT_EQ(rightsOf("/dev/no such node").group, "");
}

}  // namespace
}  // namespace slam::open_problem_test
