// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/wakeup.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <thread>

namespace slam::wakeup_test {
namespace {

bool readable(const Wakeup& wakeup, int timeout_ms = 0) {
  pollfd descriptor{wakeup.descriptor(), POLLIN, 0};
  return poll(&descriptor, 1, timeout_ms) == 1;
}

TEST(Wakeup, IsReadableFromNotifyToClear) {
  Wakeup wakeup;
  EXPECT_FALSE(readable(wakeup));
  for (int i = 0; i < 3; ++i) wakeup.notify();
  EXPECT_TRUE(readable(wakeup));
  EXPECT_TRUE(readable(wakeup)) << "stays so until it is cleared";
  wakeup.clear();
  EXPECT_FALSE(readable(wakeup));
  wakeup.clear();  // nothing to clear: must not wait
  wakeup.notify();
  EXPECT_TRUE(readable(wakeup));
}

TEST(Wakeup, WakesAnotherThreadThatPolls) {
  Wakeup there, back;
  int plain = 0;  // ordered by the wakeups alone
  std::thread other([&] {
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(readable(there, 10'000));
      there.clear();
      ++plain;
      back.notify();
    }
  });
  for (int i = 0; i < 1000; ++i) {
    there.notify();
    ASSERT_TRUE(readable(back, 10'000));
    back.clear();
  }
  other.join();
  EXPECT_EQ(plain, 1000);
}

}  // namespace
}  // namespace slam::wakeup_test
