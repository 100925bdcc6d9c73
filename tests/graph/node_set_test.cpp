// SPDX-License-Identifier: BSD-3-Clause
#include "graph/node_set.hpp"

#include <gtest/gtest.h>
#include <random>
#include <set>

namespace slam::node_set_test {
namespace {

TEST(NodeSet, HoldsWhatWasInsertedSinceItWasCleared) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> any(0, 200);
  NodeSet nodes;
  std::set<int> expected;
  for (int i = 0; i < 5000; ++i) {
    const int node = any(random);
    if (i % 300 == 299) {
      nodes.clear();
      expected.clear();
    }
    EXPECT_EQ(nodes.insert(node), expected.insert(node).second) << i;
    const int asked = any(random);
    ASSERT_EQ(nodes.contains(asked), expected.contains(asked)) << i;
  }
  EXPECT_FALSE(nodes.contains(100'000));
}

}  // namespace
}  // namespace slam::node_set_test
