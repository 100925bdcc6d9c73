// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/repeat_watch.hpp"

#include <array>
#include <gtest/gtest.h>

namespace slam {
namespace {

TEST(RepeatWatch, CallsASensorStuckAfterAsManyRepeatsAsAreNoChance) {
  RepeatWatch watch(3);
  EXPECT_FALSE(watch.isStuck(7));
  EXPECT_FALSE(watch.isStuck(7));
  EXPECT_FALSE(watch.isStuck(7));
  EXPECT_TRUE(watch.isStuck(7));
  EXPECT_TRUE(watch.isStuck(7));
  EXPECT_FALSE(watch.isStuck(8)) << "it lives again";
  EXPECT_FALSE(watch.isStuck(8));
}

TEST(RepeatWatch, NeverCallsOneStuckThatAlternates) {
  RepeatWatch watch(2);
  for (std::uint64_t i = 0; i < 20; ++i) EXPECT_FALSE(watch.isStuck(i % 2));
}

TEST(DigestOf, DiffersForOneBitAndForTheOrder) {
  const std::array<std::uint8_t, 3> a{1, 2, 3}, b{1, 2, 2}, c{3, 2, 1};
  EXPECT_EQ(digestOf(a), digestOf(a));
  EXPECT_NE(digestOf(a), digestOf(b));
  EXPECT_NE(digestOf(a), digestOf(c));
  EXPECT_EQ(digestOf(std::span(a).last(2), digestOf(std::span(a).first(1))), digestOf(a)) << "goes on where it stopped";
}

}  // namespace
}  // namespace slam
