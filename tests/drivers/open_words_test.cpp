// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/open_words.hpp"

#include <cerrno>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(OpenWords, NameTheGroupThatIsMissing) {
  EXPECT_THAT(openWords(EACCES, {"/dev/ttyUSB0", "dialout", true, false}),
              AllOf(HasSubstr("EACCES"), HasSubstr("belongs to group dialout"), HasSubstr("usermod -aG dialout $USER"),
                    HasSubstr("SupplementaryGroups=dialout")));
  EXPECT_THAT(openWords(EACCES, {"/dev/ttyUSB0", "plugdev", true, false}), HasSubstr("usermod -aG plugdev"));
  EXPECT_THAT(openWords(EACCES, {"/dev/ttyUSB0", "root", true, false}), HasSubstr("udev rules"));
  EXPECT_THAT(openWords(EACCES, {"/dev/ttyUSB0", "dialout", false, true}), HasSubstr("udev rules"));
  EXPECT_THAT(openWords(EACCES, {"/dev/ttyUSB0", "dialout", true, true}), HasSubstr("security module"));
}

TEST(OpenWords, NameNoRuleOfSlamdForAPortThatIsNoUsbAdapters) {
  for (const bool group_may : {false, true}) {
    const NodeRights on_board{"/dev/serial0", group_may ? "root" : "tty", group_may,
                              false,          /*on_usb=*/false,           "ttyAMA0"};
    EXPECT_THAT(openWords(EACCES, on_board),
                AllOf(HasSubstr("belongs to group " + on_board.group), HasSubstr("serial-getty@ttyAMA0"),
                      HasSubstr("KERNEL==\"ttyAMA0\", GROUP=\"dialout\""),
                      testing::Not(HasSubstr("install slamd's udev rules"))));
  }
}

TEST(OpenWords, TellASandboxFromAMissingRight) {
  EXPECT_THAT(openWords(EPERM, {"/dev/ttyX0", "dialout", true, true}),
              AllOf(HasSubstr("EPERM"), HasSubstr("DeviceAllow=/dev/ttyX0 rw"), HasSubstr("docker run --device")));
}

TEST(OpenWords, NameTheReasonOfAnyOtherError) {
  EXPECT_THAT(openWords(ENOENT, {}), HasSubstr("no such port"));
  EXPECT_THAT(openWords(EMFILE, {}), HasSubstr("no file descriptors are left"));
  EXPECT_THAT(openWords(EIO, {}), HasSubstr("EIO"));
  EXPECT_THAT(openWords(EINVAL, {}), HasSubstr("Invalid argument"));
}

TEST(OpenWords, KnowTheRightsOfANode) {
  const NodeRights rights = rightsOf("/dev/null");
  EXPECT_EQ(rights.group, "root");
  EXPECT_TRUE(rights.group_may);
  EXPECT_FALSE(rights.on_usb);
  EXPECT_EQ(rights.tty, "null");
  EXPECT_EQ(rightsOf("/dev/no such node").group, "");
}

TEST(Kept, IsTheSameTextForEver) {
  const char* const first = kept("some words");
  EXPECT_EQ(kept(std::string("some ") + "words"), first);
  EXPECT_STREQ(first, "some words");
  EXPECT_NE(kept("others"), first);
}

}  // namespace
}  // namespace slam
