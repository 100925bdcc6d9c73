// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/background_opener.hpp"

#include <gtest/gtest.h>

#include "drivers/polled_port.hpp"
#include "drivers/pseudo_terminal.hpp"
#include "runtime/clock.hpp"
#include "support/allocations.hpp"
#include "support/wait_until.hpp"

namespace slam::background_opener_test {
namespace {

using namespace std::chrono_literals;

TEST(BackgroundOpener, GivesWhatOpeningCameTo) {
  BackgroundOpener opener("/dev/no such port", 115200);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(opener.isDone());
    opener.ask();
    ASSERT_TRUE(test::waitUntil([&] { return opener.isDone(); }));
    const OpenedPort port = opener.take();
    EXPECT_FALSE(port.stream);
    EXPECT_EQ(port.problem.words(), "no such port: check cable and udev rule");
  }
}

TEST(BackgroundOpener, GivesAPortThatWorks) {
  test::PseudoTerminal line;
  PolledPort port(line.path(), 115200, /*in_background=*/true);
  Timestamp now = monotonicNow();
  ASSERT_TRUE(test::waitUntil([&] { return port.due(now += 10ms); }));
  ASSERT_FALSE(port.open(now));
  EXPECT_TRUE(port.isOpen());
  port.write(test::Bytes{7, 8});
  EXPECT_EQ(line.read(1s), (test::Bytes{7, 8}));
}

TEST(BackgroundOpener, ClosesForAThreadThatMustNotFree) {
  test::PseudoTerminal line;
  PolledPort port(line.path(), 115200, /*in_background=*/true);
  Timestamp now = monotonicNow();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(test::waitUntil([&] { return port.due(now += 1s); }));
    ASSERT_FALSE(port.open(now));
    const std::uint64_t freed = test::freeCount();
    port.fail(now);
    EXPECT_EQ(test::freeCount(), freed);
    EXPECT_FALSE(port.isOpen());
  }
}

TEST(BackgroundOpener, LetsWhoAsksNeitherWaitNorAllocate) {
  PolledPort port("/dev/no such port", 115200, /*in_background=*/true);
  int tries = 0;
  Timestamp now = monotonicNow();
  std::uint64_t allocated = 0;
  ASSERT_TRUE(test::waitUntil([&] {
    now += 10ms;
    allocated += test::allocationsDuring([&] {
      if (!port.due(now)) return;
      EXPECT_TRUE(port.open(now));
      ++tries;
    });
    return tries >= 3;
  }));
  EXPECT_EQ(allocated, 0U);
}

}  // namespace
}  // namespace slam::background_opener_test
