// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/latest_triple.hpp"

#include <gtest/gtest.h>
#include <thread>

namespace slam::latest_triple_test {
namespace {

TEST(LatestTriple, IsNothingUntilWritten) {
  LatestTriple triple;
  EXPECT_EQ(triple.load().time, 0);
}

TEST(LatestTriple, GivesTheNewestValueAgainAndAgain) {
  LatestTriple triple;
  triple.store({{1.0, 2.0, 3.0}, 4});
  triple.store({{5.0, 6.0, 7.0}, 8});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(triple.load().numbers[2], 7.0);
    EXPECT_EQ(triple.load().time, 8);
  }
}

/// Whose writer the processor was taken from.
struct HalfWritten : LatestTriple {
  HalfWritten() {
    store({{1.0, 2.0, 3.0}, 4});
    sequence_.fetch_add(1);
    numbers_[0].store(5.0);
  }
  void finish() {
    numbers_[1].store(6.0);
    sequence_.fetch_add(1);
  }
};

TEST(LatestTriple, IsWhatWasLoadedLastWhileItIsBeingWritten) {
  HalfWritten triple;
  EXPECT_EQ(triple.load().time, 0);
  triple.finish();
  EXPECT_EQ(triple.load().numbers, (std::array{5.0, 6.0, 3.0}));
}

TEST(LatestTriple, IsNeverTornNorOlderThanBefore) {
  LatestTriple triple;
  std::thread writer([&] {
    for (int i = 1; i <= 200000; ++i) triple.store({{i + 0.25, i + 0.5, i + 0.75}, i});
  });
  std::int64_t last = 0;
  while (last < 200000) {
    const auto& value = triple.load();
    ASSERT_GE(value.time, last);
    last = value.time;
    if (last == 0) continue;
    ASSERT_EQ(value.numbers[0], static_cast<double>(last) + 0.25);
    ASSERT_EQ(value.numbers[2], static_cast<double>(last) + 0.75);
  }
  writer.join();
}

}  // namespace
}  // namespace slam::latest_triple_test
