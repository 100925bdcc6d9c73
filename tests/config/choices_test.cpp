// SPDX-License-Identifier: BSD-3-Clause
#include "config/choices.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <set>
#include <string>

namespace slam {
namespace {

template <typename Enum>
class Choices : public testing::Test {};

using Enums = testing::Types<RunMode, LidarDriver, LidarScanMode, BaseDriver, BaseType, ImuDriver, DepthDriver, Fusion,
                             LogContent>;
TYPED_TEST_SUITE(Choices, Enums);

TYPED_TEST(Choices, NameEachEnumeratorOnce) {
  std::set<std::string> words;
  std::set<int> values;
  for (const auto& [value, word] : kChoices<TypeParam>) {
    words.insert(word);
    values.insert(static_cast<int>(value));
    EXPECT_STREQ(wordOf(value), word);
  }
  EXPECT_EQ(words.size(), kChoices<TypeParam>.size());
  EXPECT_EQ(values.size(), kChoices<TypeParam>.size());
  EXPECT_EQ(*values.rbegin() + 1, static_cast<int>(values.size())) << "an enumerator before the last has no word";
}

}  // namespace
}  // namespace slam
