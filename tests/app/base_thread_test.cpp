// SPDX-License-Identifier: BSD-3-Clause
#include "app/base_thread.hpp"

#include <gtest/gtest.h>
#include <memory>

#include "drivers/board/handsfree_fixture.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

class BaseThreadTest : public testing::Test {
 protected:
  BaseThreadTest() {
    config_.base_device.port = board_.path();
    config_.base_device.speed_commands = true;
    config_.runtime.realtime = false;
    thread_ = std::make_unique<BaseThread>(config_, *exchange_);
  }
  template <typename Condition>
  [[nodiscard]] bool serveUntil(Condition&& condition) {
    return test::waitUntil([&] {
      board_.serve();
      return condition();
    });
  }
  void drive(Duration ago) { exchange_->drives.tryPush({{.vx = 0.5}, monotonicNow() - ago}); }

  test::FakeBoard board_;
  Config config_;
  std::unique_ptr<Exchange> exchange_ = std::make_unique<Exchange>();
  std::unique_ptr<BaseThread> thread_;
};

TEST_F(BaseThreadTest, DoesNotObeyWhatWaitedInTheQueueUntilItWasOld) {
  for (int i = 0; i < 8; ++i) drive(501ms);
  thread_->worker().start();
  ASSERT_TRUE(serveUntil([&] { return !board_.drives.empty() && thread_->wheelStatus()->samples > 5; }));
  for (const auto& drive : board_.drives) EXPECT_EQ(drive.speed.x, 0.0F);
}

TEST_F(BaseThreadTest, StopsTheRobotAtItsEnd) {
  thread_->worker().start();
  ASSERT_TRUE(serveUntil([&] {
    drive(0ms);
    return board_.speed.x == 0.5F;
  }));
  thread_->stop();
  board_.serve();
  EXPECT_EQ(board_.speed.x, 0.0F);
}

}  // namespace
}  // namespace slam
