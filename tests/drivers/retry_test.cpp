// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/retry.hpp"

#include <gtest/gtest.h>

namespace slam::retry_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kNow{100s};

TEST(Retry, IsDueAtOnceUntilSomethingFailed) { EXPECT_TRUE(Retry(200ms).due(kNow)); }

TEST(Retry, WaitsTwiceAsLongEachTimeButNoLongerThanASecond) {
  Retry retry(200ms);
  for (const Duration wait : {200ms, 400ms, 800ms, 1000ms, 1000ms}) {
    retry.failed(kNow);
    EXPECT_FALSE(retry.due(kNow + wait - 1ms));
    EXPECT_TRUE(retry.due(kNow + wait));
  }
}

TEST(Retry, WaitsAsLongAsItIsAskedTo) {
  Retry retry(1s, 5s);
  for (const Duration wait : {1s, 2s, 4s, 5s, 5s}) {
    retry.failed(kNow);
    EXPECT_FALSE(retry.due(kNow + wait - 1ms));
    EXPECT_TRUE(retry.due(kNow + wait));
  }
}

TEST(Retry, BeginsWithTheFirstWaitAgainAfterASuccess) {
  Retry retry(100ms);
  for (int i = 0; i < 5; ++i) retry.failed(kNow);
  retry.succeeded();
  retry.failed(kNow);
  EXPECT_TRUE(retry.due(kNow + 100ms));
}

}  // namespace
}  // namespace slam::retry_test
