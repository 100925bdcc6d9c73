// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/thread_watchdog.hpp"

#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tools/files.hpp"

namespace slam::thread_watchdog_test {
namespace {

using namespace std::chrono_literals;

/// What systemd is told.
class Systemd {
 public:
  Systemd() {
    const std::string path = folder_ / "notify";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~Systemd() {
    ::unsetenv("NOTIFY_SOCKET");
    ::close(socket_);
  }
  int feeds() {
    int count = 0;
    char text[64];
    for (ssize_t size; (size = ::recv(socket_, text, sizeof text, MSG_DONTWAIT)) > 0;)
      count += std::string_view(text, static_cast<std::size_t>(size)) == "WATCHDOG=1" ? 1 : 0;
    return count;
  }

 private:
  const test::Folder folder_;
  const int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

/// Threads that were never started: they do not tick.
class Threads : public testing::Test {
 protected:
  std::string look(Duration later) {
    testing::internal::CaptureStderr();
    watchdog.look(Timestamp{} + later);
    return testing::internal::GetCapturedStderr();
  }

  Systemd systemd;
  DeviceStatus status;
  Worker lidar{{.name = "lidar"}, [] {}}, depth{{.name = "depth"}, [] {}};
  ThreadWatchdog watchdog{100ms};
};

TEST_F(Threads, FeedSystemdOnlyWhileAllVitalOnesAreAlive) {
  watchdog.add(lidar, {200ms, 1s});
  watchdog.add(depth, {200ms, 400ms, /*vital=*/false});
  std::string log;
  for (int i = 0; i <= 8; ++i) log += look(i * 100ms);
  EXPECT_EQ(systemd.feeds(), 9) << "one that is not vital is dead";
  EXPECT_THAT(log, testing::HasSubstr("thread depth does not tick"));
  EXPECT_THAT(log, testing::Not(testing::HasSubstr("thread lidar does not tick")));
  for (int i = 9; i <= 12; ++i) log += look(i * 100ms);
  EXPECT_EQ(systemd.feeds(), 2);
  EXPECT_THAT(log, testing::HasSubstr("thread lidar does not tick"));
  EXPECT_THAT(watchdog.problems(Timestamp{} + 1200ms).at(0).words(), testing::HasSubstr("lidar"));
  EXPECT_THAT(watchdog.workers(), testing::ElementsAre(&lidar, &depth));
}

TEST_F(Threads, AreNotLateWhileTheirDeviceConnects) {
  watchdog.add(lidar, {200ms, 10s}, &status);
  status.set(DeviceState::kOpening, problem::kOpening);
  for (int i = 0; i <= 5; ++i) look(i * 100ms);
  EXPECT_TRUE(watchdog.problems(Timestamp{} + 500ms).empty());
  status.set(DeviceState::kStreaming);
  look(600ms);
  EXPECT_THAT(watchdog.problems(Timestamp{} + 600ms).at(0).words(), testing::HasSubstr("thread lidar was late"));
}

}  // namespace
}  // namespace slam::thread_watchdog_test
