// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/companion.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::companion_test {
namespace {

TEST(Companion, IsExpectedThroughLosses) {
  Companion companion;
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    companion.note(random() % 10 >= 2);
    ASSERT_TRUE(companion.expected()) << i;
  }
}

TEST(Companion, IsNotExpectedWhereItIsNeverOrSeldomThere) {
  for (const int every : {0, 2, 3, 10}) {
    Companion companion;
    for (int i = 0; i < 200; ++i) companion.note(every != 0 && i % every == 0);
    EXPECT_FALSE(companion.expected()) << every;
    for (int i = 0; i < 1000; ++i) {
      companion.note(every != 0 && i % every == 0);
      ASSERT_FALSE(companion.expected()) << every;
    }
    for (int i = 0; i < 200; ++i) companion.note(true);
    EXPECT_TRUE(companion.expected()) << "it is there again";
  }
}

}  // namespace
}  // namespace slam::companion_test
