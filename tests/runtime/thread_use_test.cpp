// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/thread_use.hpp"

#include <atomic>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <thread>
#include <unistd.h>

#include "runtime/clock.hpp"
#include "tools/files.hpp"

namespace slam::thread_use_test {
namespace {

using namespace std::chrono_literals;

TEST(ThreadUseTest, IsReadOfWhatTheKernelCounts) {
  const test::Folder root;
  std::filesystem::create_directories(root / "proc/self/task/7");
  EXPECT_FALSE(threadUse(7, root / ""));
  root.write("proc/self/task/7/stat", "7 (a) R b) S 1 2 3\n");
  ASSERT_TRUE(threadUse(7, root / ""));
  EXPECT_EQ(threadUse(7, root / "")->waited, 0ns) << "a kernel that does not count";
  root.write("proc/self/task/7/schedstat", "5000000000 250000000 12\n");
  auto use = threadUse(7, root / "");
  EXPECT_EQ(use->ran, 5s);
  EXPECT_EQ(use->waited, 250ms);
  EXPECT_FALSE(use->is_ready) << "its name holds the letter of one that is";
  root.write("proc/self/task/7/stat", "7 (a) S b) R 1 2 3\n");
  EXPECT_TRUE(threadUse(7, root / "")->is_ready);
}

TEST(ThreadUseTest, DistinguishesAThreadThatWaitsForItsTurnFromOneThatWorksOrSleeps) {
  const ThreadUse before{.ran = 1s, .waited = 1s};
  EXPECT_EQ(starvedBetween(before, {.ran = 1s, .waited = 1s, .is_ready = true}, 100ms), 100ms) << "not counted yet";
  EXPECT_EQ(starvedBetween(before, {.ran = 1030ms, .waited = 1s, .is_ready = true}, 100ms), 70ms);
  EXPECT_EQ(starvedBetween(before, {.ran = 1100ms, .waited = 1s, .is_ready = true}, 100ms), 0ms) << "it computes";
  EXPECT_EQ(starvedBetween(before, {.ran = 1s, .waited = 1s, .is_ready = false}, 100ms), 0ms) << "it is kept waiting";
  EXPECT_EQ(starvedBetween(before, {.ran = 1s, .waited = 1060ms, .is_ready = false}, 100ms), 60ms);
  EXPECT_EQ(starvedBetween(before, {.ran = 1s, .waited = 9s, .is_ready = false}, 100ms), 100ms)
      << "the end of a wait whose begin was counted already";
}

TEST(BlockedTimeTest, CountsWaitsForAnythingButTheCpu) {
  std::atomic<int> step{0};
  BlockedTime blocked;
  EXPECT_EQ(blocked.until(monotonicNow()), 0ns);
  std::thread thread([&] {
    blocked.begin(monotonicNow());
    step = 1;
    step.notify_all();
    while (step == 1) {  // computes, or waits for its turn
    }
    step.wait(2);
    blocked.end();
  });
  step.wait(0);
  EXPECT_EQ(blocked.until(monotonicNow() + 5s), 0ns) << "it wants the CPU";
  step = 2;
  while (blocked.until(monotonicNow() + 60s) < 59s) std::this_thread::yield();
  step = 3;
  step.notify_all();
  thread.join();
  EXPECT_EQ(blocked.until(monotonicNow() + 60s), 0ns);
}

}  // namespace
}  // namespace slam::thread_use_test
