// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/job_thread.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "runtime/clock.hpp"
#include "support/wait_until.hpp"

namespace slam::job_thread_test {
namespace {

using namespace std::chrono_literals;

/// A job that hangs until it is let go.
struct Hang {
  std::atomic<bool> begun{false}, let_go{false};
  std::function<void()> job() {
    return [this] {
      begun = true;
      begun.notify_all();
      let_go.wait(false);
    };
  }
  void release() {
    let_go = true;
    let_go.notify_all();
  }
};

TEST(JobThread, RunsItsJobsInTheirOrder) {
  std::vector<int> done;  // read behind the wait: ThreadSanitizer would object otherwise
  JobThread jobs("jobs");
  EXPECT_FALSE(jobs.isBusy());
  for (int i = 0; i < 50; ++i) jobs.start([&done, i] { done.push_back(i); });
  ASSERT_TRUE(jobs.waitUntilIdle(monotonicNow() + 20s));
  ASSERT_EQ(done.size(), 50U);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(JobThread, LetsNobodyWaitForAJobThatHangs) {
  Hang hang;
  JobThread jobs("jobs");
  EXPECT_EQ(jobs.blockedFor(monotonicNow()), Duration(0));
  jobs.start(hang.job());
  hang.begun.wait(false);
  EXPECT_TRUE(jobs.isBusy());
  EXPECT_TRUE(test::waitUntil([&] { return jobs.blockedFor(monotonicNow() + 10s) >= 10s; }))
      << "once it has gone to sleep";
  EXPECT_FALSE(jobs.waitUntilIdle(monotonicNow()));
  hang.release();
  EXPECT_TRUE(jobs.waitUntilIdle(monotonicNow() + 20s));
  EXPECT_FALSE(jobs.isBusy());
  EXPECT_EQ(jobs.blockedFor(monotonicNow() + 10s), Duration(0));
}

TEST(JobThread, DoesAllItWasGivenBeforeItEnds) {
  int done = 0;
  {
    JobThread jobs("jobs");
    for (int i = 0; i < 20; ++i) jobs.start([&done] { ++done; });
  }
  EXPECT_EQ(done, 20);
}

TEST(JobThread, IsBusySinceItsPresentJobBegan) {
  Hang first, second;
  JobThread jobs("jobs");
  jobs.start(first.job());
  jobs.start(second.job());
  first.begun.wait(false);
  const Timestamp later = monotonicNow();
  while (monotonicNow() < later + 20ms) std::this_thread::yield();
  first.release();
  second.begun.wait(false);
  const Timestamp now = monotonicNow();
  EXPECT_LE(jobs.blockedFor(now), now - (later + 20ms)) << "the first one's time does not count";
  second.release();
  EXPECT_TRUE(jobs.waitUntilIdle(monotonicNow() + 20s));
}

TEST(JobThread, IsBusySinceItsFirstJobHoweverManyFollow) {
  Hang hang;
  JobThread jobs("jobs");
  jobs.start(hang.job());
  ASSERT_TRUE(test::waitUntil([&] { return jobs.blockedFor(monotonicNow()) >= 20ms; }));
  jobs.start([] {});
  EXPECT_GE(jobs.blockedFor(monotonicNow()), 20ms) << "a disk that hangs is told, whatever else waits for it";
  hang.release();
}

}  // namespace
}  // namespace slam::job_thread_test
