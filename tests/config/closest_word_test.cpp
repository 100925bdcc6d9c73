// SPDX-License-Identifier: BSD-3-Clause
#include "config/closest_word.hpp"

#include <gtest/gtest.h>

namespace slam::closest_word_test {
namespace {

TEST(ClosestWord, IsTheKnownOneWithTheFewestEdits) {
  EXPECT_EQ(editDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(editDistance("", "abc"), 3U);
  EXPECT_EQ(closestWord("staus", {"save", "status", "start"}), "status");
}

TEST(ClosestWord, IsNoneWhereNoWordIsLikeIt) {
  EXPECT_EQ(closestWord("kitchen", {"save", "status"}), "");
  EXPECT_EQ(closestWord("status", {}), "");
}

}  // namespace
}  // namespace slam::closest_word_test
