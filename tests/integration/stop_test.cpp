// SPDX-License-Identifier: BSD-3-Clause
// slamd drives a board that has no watchdog, and ends in each way that there is.
#include <csignal>
#include <gtest/gtest.h>
#include <slam/drive_t.hpp>

#include "bus/channels.hpp"
#include "drivers/board/handsfree_fixture.hpp"
#include "integration/live.hpp"

namespace slam::stop_test {
namespace {

using namespace std::chrono_literals;

class Stop : public test::Live {
 protected:
  void SetUp() override {
    Live::SetUp();
    ASSERT_TRUE(listener_.good());
    std::filesystem::create_directories(folder_ / "devices");
    std::filesystem::create_symlink(board_.path(), folder_ / "devices" / "board");
    start();
  }
  void start() {
    startDaemon({"base.speed_commands=true", "lidar.driver='none'", "depth.driver='none'", "runtime.realtime=false"});
  }
  template <typename Condition>
  bool serveUntil(Condition&& condition, std::chrono::milliseconds limit) {
    for (const auto end = test::Clock::now() + limit; !condition();) {
      if (test::Clock::now() > end) return false;
      board_.serve();
    }
    return true;
  }
  bool stands() const { return board_.speed.x == 0.0F; }
  void driveUntilItMoves() {
    ASSERT_TRUE(serveUntil(
        [this] {
          drive_t drive{};
          drive.utime =
              std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
                  .count();
          drive.vx = 0.5;
          listener_.lcm().publish(channel::kDrive, &drive);
          return !stands();
        },
        20s))
        << daemonLog();
  }

  test::Listener listener_;
  test::FakeBoard board_;
};

TEST_F(Stop, IsSentByTheSlamdThatFollowsOneThatWasKilled) {
  driveUntilItMoves();
  slamd_->signal(SIGKILL);
  ASSERT_TRUE(slamd_->wait(5s));
  ASSERT_FALSE(serveUntil([&] { return stands(); }, 1s)) << "nobody stops it";
  start();
  EXPECT_TRUE(serveUntil([&] { return stands(); }, 20s)) << daemonLog();
}

TEST_F(Stop, IsSentAtEachSignalThatEndsSlamdInOrder) {
  for (const int number : {SIGHUP, SIGTERM, SIGINT}) {
    driveUntilItMoves();
    slamd_->signal(number);
    std::optional<int> code;
    EXPECT_TRUE(serveUntil([&] { return (code = slamd_->wait(0ms)).has_value(); }, 20s)) << number;
    EXPECT_EQ(code, 0) << number << "\n" << daemonLog();
    board_.serve();
    EXPECT_TRUE(stands()) << number;
    board_.speed = {};
    start();
  }
}

}  // namespace
}  // namespace slam::stop_test
