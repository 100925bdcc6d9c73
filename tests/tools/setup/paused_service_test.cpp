// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/paused_service.hpp"

#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tools/files.hpp"

namespace slam::paused_service_test {
namespace {

/// A systemctl that writes what it is asked for into a pipe, and fails where a file of that verb is there.
class ServicePause : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(mkfifo((folder_ / "calls").c_str(), 0600), 0);
    calls_ = open((folder_ / "calls").c_str(), O_RDWR | O_CLOEXEC);
    const std::filesystem::path program =
        folder_.write("systemctl", "#!/bin/sh\ncd $(dirname $0)\necho \"$2\" > calls\n[ ! -e \"fail-$2\" ]\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    path_ = std::getenv("PATH");
    setenv("PATH", (program.parent_path().string() + ":" + path_).c_str(), 1);
  }
  void TearDown() override {
    setenv("PATH", path_.c_str(), 1);
    close(calls_);
  }
  /// The next line; empty: none within some seconds.
  std::string nextCall() {
    std::string line;
    for (pollfd waiting{calls_, POLLIN, 0}; ::poll(&waiting, 1, 5000) == 1;) {
      char letter = 0;
      if (read(calls_, &letter, 1) != 1 || letter == '\n') break;
      line += letter;
    }
    return line;
  }
  bool isQuiet() {
    pollfd waiting{calls_, POLLIN, 0};
    return ::poll(&waiting, 1, 0) == 0;
  }

  test::Folder folder_;
  std::string path_;
  int calls_ = -1;
};

TEST_F(ServicePause, StopsTheServiceAndStartsItAgain) {
  EXPECT_TRUE(PausedService::runs());
  EXPECT_EQ(nextCall(), "is-active");
  {
    PausedService paused;
    EXPECT_EQ(nextCall(), "stop");
    EXPECT_TRUE(isQuiet());
  }
  EXPECT_EQ(nextCall(), "start");
  EXPECT_TRUE(isQuiet()) << "once";
  folder_.write("fail-is-active", "");
  EXPECT_FALSE(PausedService::runs());
}

TEST_F(ServicePause, StartsTheServiceOfAProgramThatWasKilled) {
  const pid_t victim = fork();
  if (victim == 0) {
    const PausedService paused;
    for (;;) pause();
  }
  EXPECT_EQ(nextCall(), "stop");
  kill(victim, SIGKILL);
  waitpid(victim, nullptr, 0);
  EXPECT_EQ(nextCall(), "start");
}

TEST_F(ServicePause, NamesAServiceThatCannotBeStoppedOrStarted) {
  folder_.write("fail-stop", "");
  EXPECT_THROW(PausedService(), std::runtime_error);
  EXPECT_EQ(nextCall(), "stop");
  EXPECT_EQ(nextCall(), "start") << "it may have been half-way";
  std::filesystem::remove(folder_ / "fail-stop");
  folder_.write("fail-start", "");
  PausedService paused;
  EXPECT_FALSE(paused.resume());
  EXPECT_TRUE(paused.resume()) << "nothing is left to be done";
}

}  // namespace
}  // namespace slam::paused_service_test
