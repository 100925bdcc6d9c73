// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/pseudo_terminal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tools/files.hpp"

namespace slam::sim::pseudo_terminal_test {
namespace {

/// As somebody who is not root, for whom alone the kernel looks at it. @return whether the port could be opened
bool opens(const std::string& port) {
  const pid_t stranger = fork();
  if (stranger == 0) {
    constexpr int kNobody = 65534;
    if (geteuid() == 0 && (setgid(kNobody) != 0 || setuid(kNobody) != 0)) _exit(2);
    _exit(open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC) >= 0 ? 0 : 1);
  }
  int status = 0;
  waitpid(stranger, &status, 0);
  return status == 0;
}

TEST(PseudoTerminal, CanBeOpenedAgainAfterADriverThatWasKilled) {
  const test::Folder folder;
  const std::string link = folder / "port";
  PseudoTerminal terminal(link);
  ASSERT_EQ(chmod(link.c_str(), 0666), 0);
  ASSERT_TRUE(opens(link));
  const int driver = open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_EQ(ioctl(driver, TIOCEXCL), 0);
  EXPECT_FALSE(opens(link));
  close(driver);
  terminal.stream();
  EXPECT_TRUE(opens(link));
}

}  // namespace
}  // namespace slam::sim::pseudo_terminal_test
