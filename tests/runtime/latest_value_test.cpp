// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/latest_value.hpp"

#include <gtest/gtest.h>
#include <thread>

namespace slam::latest_value_test {
namespace {

TEST(LatestValue, IsNotThereBeforeTheFirstStore) {
  LatestValue<int> latest;
  int value = 42;
  EXPECT_FALSE(latest.load(value));
  EXPECT_EQ(value, 42);
}

TEST(LatestValue, IsGivenOnceAndIsTheNewest) {
  LatestValue<int> latest;
  int value = 0;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i <= round % 4; ++i) latest.store(10 * round + i);
    EXPECT_TRUE(latest.load(value));
    EXPECT_EQ(value, 10 * round + round % 4);
    EXPECT_FALSE(latest.load(value));
  }
}

TEST(LatestValue, IsNeverTornAndNeverOlderThanTheOneBefore) {
  constexpr std::uint64_t kCount = 300'000;
  using Words = std::array<std::uint64_t, 16>;
  LatestValue<Words> latest;
  std::thread writer([&] {
    Words words;
    for (std::uint64_t i = 1; i <= kCount; ++i) {
      words.fill(i);
      latest.store(words);
    }
  });
  Words words{};
  std::uint64_t last = 0, torn = 0, older = 0;
  while (last < kCount) {  // the last value stored is always seen in the end
    if (!latest.load(words)) continue;
    for (const std::uint64_t word : words) torn += word != words[0] ? 1U : 0U;
    older += words[0] <= last ? 1U : 0U;
    last = words[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(older, 0U);
  EXPECT_FALSE(latest.load(words));
}

}  // namespace
}  // namespace slam::latest_value_test
