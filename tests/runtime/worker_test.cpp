// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/worker.hpp"

#include <chrono>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "runtime/clock.hpp"
#include "support/wait_until.hpp"

namespace slam::worker_test {
namespace {

using std::chrono::milliseconds;
using test::waitUntil;

TEST(Worker, ShowsWhatItsThreadHasOfTheCpu) {
  std::atomic<bool> begun{false};
  Worker worker({.name = "busy"}, [&] {
    begun = true;
    begun.notify_all();
  });
  EXPECT_FALSE(worker.use());
  worker.start();
  begun.wait(false);
  const auto before = worker.use();
  ASSERT_TRUE(before);
  Duration had{0};  // it never rests: it runs, or waits for its turn
  while (had < std::chrono::milliseconds(20)) {
    const auto now = worker.use();
    ASSERT_TRUE(now);
    EXPECT_TRUE(now->is_ready);
    had = now->ran + now->waited - before->ran - before->waited;
  }
  worker.stop();
  EXPECT_FALSE(worker.use());
}

TEST(Worker, DoesNotRunBeforeItsStart) {
  Worker worker({.name = "idle", .rate = 1000.0}, [] { FAIL(); });
  EXPECT_EQ(worker.ticks(), 0U);
  EXPECT_EQ(worker.name(), "idle");
  EXPECT_EQ(worker.rate(), 1000.0);
  worker.stop();  // nothing to stop
}

TEST(Worker, TicksAtAFixedRate) {
  const Timestamp begin = monotonicNow();
  std::atomic<int> calls{0};
  Worker worker({.name = "ticker", .rate = 200.0}, [&] { ++calls; });
  worker.start();
  ASSERT_TRUE(waitUntil([&] { return worker.ticks() >= 20; }));
  worker.stop();
  const auto elapsed = toSeconds(monotonicNow() - begin);
  EXPECT_LE(static_cast<double>(worker.ticks()), elapsed * 200.0 + 1.0) << "never faster than its rate";
  EXPECT_EQ(worker.ticks(), static_cast<std::uint64_t>(calls));
  EXPECT_EQ(worker.duration().summary().count, calls);
  EXPECT_GE(worker.lateness().summary().count, calls - 1);
  EXPECT_EQ(worker.warning(), "") << "normal scheduling needs no rights";
}

TEST(Worker, CountsAnOverrunAndSkipsTheDeadlinesItMissed) {
  constexpr double kRate = 50.0;
  std::atomic<bool> hold{false}, held{false};
  Worker worker({.name = "slow", .rate = kRate}, [&] {
    if (!hold) return;
    held = true;
    held.notify_all();
    hold.wait(true);
  });
  worker.start();
  ASSERT_TRUE(waitUntil([&] { return worker.ticks() >= 2; }));
  const std::uint64_t overruns = worker.overruns();
  hold = true;
  held.wait(false);
  const Timestamp blocked = monotonicNow();
  ASSERT_TRUE(waitUntil([&] { return monotonicNow() - blocked > milliseconds(500); }));  // 25 deadlines pass
  const std::uint64_t before = worker.ticks();
  const Timestamp released = monotonicNow();
  hold = false;
  hold.notify_all();
  ASSERT_TRUE(waitUntil([&] { return worker.ticks() >= before + 4; }));
  const std::uint64_t after = worker.ticks();
  const double elapsed = toSeconds(monotonicNow() - released);
  EXPECT_GT(worker.overruns(), overruns);
  EXPECT_LE(static_cast<double>(after - before), elapsed * kRate + 3.0) << "no burst";
  worker.stop();
  EXPECT_GE(worker.duration().summary().max_us, 500e3);
  EXPECT_GE(worker.takeWorstDelay(), milliseconds(480)) << "of the tick that was due meanwhile";
  EXPECT_EQ(worker.takeWorstDelay(), Duration(0)) << "is told once";
}

TEST(Worker, IsWokenBetweenItsDeadlines) {
  Wakeup wakeup;
  std::atomic<int> calls{0}, woken{0};
  Worker worker(
      {.name = "woken", .rate = 0.1}, [&] { ++calls; }, wakeup, [&] { ++woken; });
  worker.start();
  ASSERT_TRUE(waitUntil([&] { return worker.ticks() == 1; }));
  for (int i = 1; i <= 20; ++i) {
    wakeup.notify();
    ASSERT_TRUE(waitUntil([&] { return woken == i; })) << i;
  }
  EXPECT_EQ(worker.ticks(), 1U) << "a wake-up is no tick, ...";
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(worker.lateness().summary().count, 1);
  worker.requestStop();
  wakeup.notify();  // ... and ends a long wait
  worker.stop();
}

TEST(Worker, KeepsItsRateHoweverOftenItIsWoken) {
  Wakeup wakeup;
  std::atomic<bool> quit{false};
  std::atomic<int> woken{0};
  Worker worker(
      {.name = "often", .rate = 100.0}, [] {}, wakeup, [&] { ++woken; });
  const Timestamp begin = monotonicNow();
  worker.start();
  std::thread waking([&] {
    while (!quit) wakeup.notify(), std::this_thread::yield();
  });
  ASSERT_TRUE(waitUntil([&] { return worker.ticks() >= 20; }));
  const double elapsed = toSeconds(monotonicNow() - begin);
  EXPECT_LE(static_cast<double>(worker.ticks()), elapsed * 100.0 + 1.0);
  EXPECT_GT(woken, 20);
  quit = true;
  waking.join();
}

TEST(Worker, WithoutARateCallsItsBodyAgainAtOnce) {
  std::atomic<int> permits{0}, calls{0};
  std::atomic<bool> quit{false};
  Worker worker({.name = "free"}, [&] {
    while (permits == 0 && !quit) std::this_thread::yield();
    if (quit) return;
    --permits;
    ++calls;
  });
  worker.start();
  permits = 500;
  EXPECT_TRUE(waitUntil([&] { return calls == 500; }));
  worker.requestStop();
  EXPECT_TRUE(worker.stopping());
  quit = true;
  worker.stop();
  EXPECT_EQ(calls, 500);
  EXPECT_EQ(worker.lateness().summary().count, 0);
  EXPECT_EQ(worker.overruns(), 0U);
}

TEST(Worker, GivesTheCpuTimeOfItsThreadAlone) {
  std::atomic<bool> quit{false};
  Worker worker({.name = "busy"}, [] {}), idle({.name = "idle"}, [&] {
    while (!quit) std::this_thread::sleep_for(milliseconds(1));
  });
  EXPECT_EQ(worker.cpuSeconds(), 0.0) << "before its start";
  worker.start();
  idle.start();
  ASSERT_TRUE(waitUntil([&] { return worker.cpuSeconds() > 0.05; }));
  EXPECT_LT(idle.cpuSeconds(), 0.5 * worker.cpuSeconds());
  quit = true;
  worker.stop();
  EXPECT_EQ(worker.cpuSeconds(), 0.0) << "after its end";
}

TEST(Worker, EndsWhenItsBodyAsksForIt) {
  Worker* self = nullptr;
  int calls = 0;
  Worker worker({.name = "once", .rate = 1000.0}, [&] {
    ++calls;
    self->requestStop();
  });
  self = &worker;
  worker.start();
  ASSERT_TRUE(waitUntil([&] { return worker.stopping().load(); }));
  worker.stop();
  EXPECT_EQ(calls, 1);
}

TEST(Worker, IsJoinedByStopAndByItsDestructor) {
  int plain = 0;  // read after the join: ThreadSanitizer would object otherwise
  {
    std::atomic<bool> ran{false};
    Worker worker({.name = "joined", .rate = 1000.0}, [&] {
      ++plain;
      ran = true;
    });
    worker.start();
    ASSERT_TRUE(waitUntil([&] { return ran.load(); }));
  }
  EXPECT_GE(plain, 1);
}

TEST(Worker, OfATurnThatDoesNotEndIsNotWaitedForLongerThanAllowed) {
  std::atomic<bool> begun{false}, released{false};
  EXPECT_TRUE(Worker({.name = "idle"}, [] {}).stop(monotonicNow())) << "it was never started";
  Worker stuck({.name = "stuck"}, [&] {
    begun = true;
    begun.notify_all();
    released.wait(false);
  });
  stuck.start();
  begun.wait(false);
  EXPECT_FALSE(stuck.stop(monotonicNow() + milliseconds(20)));
  EXPECT_FALSE(stuck.stop(monotonicNow() - milliseconds(20)));
  released = true;
  released.notify_all();
  EXPECT_TRUE(stuck.stop(monotonicNow() + std::chrono::seconds(20)));
  EXPECT_EQ(stuck.ticks(), 1U);
  EXPECT_TRUE(stuck.stop(monotonicNow())) << "as often as one likes";
}

TEST(Worker, ReportsWhatStandsInTheWayOfRealTimeScheduling) {
  Worker worker({.name = "realtime", .rate = 1000.0, .priority = 10}, [] {});
  worker.start();
  ASSERT_TRUE(waitUntil([&] { return worker.ticks() > 0; }));
  worker.stop();
  if (worker.warning().empty()) GTEST_SKIP() << "this process may use SCHED_FIFO";
  EXPECT_GT(worker.warning().size(), 10U);
}

TEST(Worker, GoesOnAtTheNextDeadlineNotAtOnce) {
  constexpr Duration kPeriod = milliseconds(400);
  std::vector<Timestamp> begun;  // read behind the join
  std::atomic<int> count{0};
  Worker worker({.name = "held", .rate = 1.0 / toSeconds(kPeriod)}, [&] {
    begun.push_back(monotonicNow());
    if (begun.size() == 1) {
      while (monotonicNow() < begun[0] + kPeriod + kPeriod / 4) std::this_thread::yield();
    }
    ++count;
  });
  worker.start();
  ASSERT_TRUE(waitUntil([&] { return count >= 2; }));
  worker.stop();
  EXPECT_GE(begun[1] - begun[0], kPeriod * 7 / 4) << "the deadline that it missed is skipped";
  EXPECT_GE(worker.overruns(), 1U);
  EXPECT_GE(worker.takeWorstDelay(), kPeriod * 3 / 4) << "of the tick that was skipped";
}

}  // namespace
}  // namespace slam::worker_test
