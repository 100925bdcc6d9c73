// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/search/port_holder.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "drivers/pseudo_terminal.hpp"
#include "drivers/serial_port.hpp"
#include "tools/files.hpp"

namespace slam::port_holder_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A child process that has a port open and locked, as a terminal program does.
class Holder {
 public:
  Holder(const std::string& port, const char* name) {
    int ready[2];
    EXPECT_EQ(pipe(ready), 0);
    id_ = fork();
    if (id_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      prctl(PR_SET_NAME, name);
      const int descriptor = open(port.c_str(), O_RDWR | O_NOCTTY);
      const char locked = descriptor >= 0 && flock(descriptor, LOCK_EX | LOCK_NB) == 0 ? 'y' : 'n';
      if (write(ready[1], &locked, 1) == 1) pause();
      _exit(0);
    }
    char locked = 0;
    EXPECT_EQ(read(ready[0], &locked, 1), 1);
    EXPECT_EQ(locked, 'y');
    close(ready[0]);
    close(ready[1]);
  }
  ~Holder() {
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;
  std::string id() const { return std::to_string(id_); }

 private:
  pid_t id_ = -1;
};

/// A program below root/proc that has a file open.
void addProgram(const test::Folder& root, const std::string& id, const std::string& name, const char* file) {
  fs::create_directories(root / ("proc/" + id + "/fd"));
  root.write("proc/" + id + "/comm", name + "\n");
  fs::create_symlink(file, root / ("proc/" + id + "/fd/5"));
}

TEST(PortHolder, IsNamedByWhoCannotOpenThePort) {
  const test::PseudoTerminal line;
  {
    const Holder holder(line.path(), "minicom");
    SerialPort port;
    const Problem problem = port.open(line.path(), 115200);
    ASSERT_TRUE(problem.is(problem::kPortHeld)) << problem.words();
    EXPECT_EQ(problem.cause(), "the port is in use by another program (minicom, " + holder.id() + ")");
    EXPECT_THAT(problem.fix(), HasSubstr("systemctl stop minicom"));
  }
  SerialPort again;
  EXPECT_FALSE(again.open(line.path(), 115200)) << "the other program has ended";
}

TEST(PortHolder, IsNotTheProgramThatAsks) {
  const test::PseudoTerminal line;
  SerialPort one, other;
  ASSERT_FALSE(one.open(line.path(), 115200));
  EXPECT_TRUE(other.open(line.path(), 115200).is(problem::kPortInUse)) << "two devices with one port";
  EXPECT_TRUE(portInUse("/dev/no such port").is(problem::kPortInUse));
}

TEST(PortHolder, IsFoundByItsDescriptors) {
  const test::Folder root;
  EXPECT_FALSE(holderOf("/dev/ttyUSB0", root / "")) << "there is no /proc";
  addProgram(root, "812", "slamd", "/dev/ttyUSB0");
  addProgram(root, "813", "odd \x1b[2J\xff", "/dev/ttyUSB2");
  addProgram(root, "814", "slam-sim", "/dev/pts/3");
  fs::create_directories(root / "proc/self/fd");  // no program's folder
  ASSERT_TRUE(holderOf("/dev/ttyUSB0", root / ""));
  EXPECT_EQ(holderOf("/dev/ttyUSB0", root / "")->name, "slamd");
  EXPECT_EQ(holderOf("/dev/ttyUSB0", root / "")->id, "812");
  EXPECT_FALSE(holderOf("/dev/ttyUSB0", root / "", "slamd"));
  EXPECT_FALSE(holderOf("/dev/ttyUSB1", root / ""));
  EXPECT_EQ(holderOf("/dev/ttyUSB2", root / "")->name, "odd ?[2J?") << "a name is text, whatever a program has set";
  EXPECT_FALSE(holderOf("/dev/pts/3", root / "")) << "a pseudo-terminal's maker has it open by right";
  EXPECT_EQ(runningPrograms(root / "").size(), 3U);
}

/// slamd's user under systemd sees no other user's programs, but their lock files.
TEST(PortHolder, IsNamedByALockFileWhereItsProgramCannotBeSeen) {
  const test::Folder root;
  const test::PseudoTerminal line;
  fs::create_directories(root / "run/lock");
  const std::string lock = "run/lock/LCK.." + fs::canonical(line.path()).filename().string();
  std::string ended;
  {
    const Holder holder(line.path(), "minicom");
    ended = holder.id();
    root.write(lock, "      " + holder.id() + " minicom robot\n");
    EXPECT_EQ(portInUse(line.path(), root / "").cause(),
              "the port is in use by another program (minicom, " + holder.id() + ")");
    root.write(lock, holder.id() + "\n");
    EXPECT_EQ(portInUse(line.path(), root / "").cause(),
              "the port is in use by another program (?, " + holder.id() + ")");
    root.write(lock, holder.id() + " \x1b[2J" + std::string(5000, 'm'));
    EXPECT_LT(portInUse(line.path(), root / "").cause().size(), 100U);
  }
  const std::string own = std::to_string(getpid());
  for (const std::string& useless :
       {ended + " minicom robot\n", own + " slamd\n", std::string("minicom 12\n"), std::string("-5 minicom\n"),
        std::string("99999999999999 minicom\n"), std::string()}) {
    root.write(lock, useless);
    EXPECT_TRUE(portInUse(line.path(), root / "").is(problem::kPortInUse)) << useless;
  }
}

}  // namespace
}  // namespace slam::port_holder_test
