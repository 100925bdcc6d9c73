// SPDX-License-Identifier: BSD-3-Clause
#include "config/choices.hpp"

#include <cstddef>
#include <gtest/gtest.h>
#include <set>
#include <string>

namespace slam::choices_test {
namespace {

template <typename Enum>
class Choices : public testing::Test {};

using Enums = testing::Types<RunMode, LidarDriver, LidarScanMode, BaseDriver, BaseType, DriveOrder, ImuDriver,
                             DepthDriver, Fusion, MatchMethod, LogContent, can::Protocol>;
TYPED_TEST_SUITE(Choices, Enums);

TYPED_TEST(Choices, NameEachEnumeratorOnce) {
  std::set<std::string> words;
  for (std::size_t i = 0; i < kWords<TypeParam>.size(); ++i) {
    words.insert(kWords<TypeParam>[i]);
    EXPECT_STREQ(wordOf(static_cast<TypeParam>(i)), kWords<TypeParam>[i]);
  }
  EXPECT_GE(words.size(), 2U);
  EXPECT_EQ(words.size(), kWords<TypeParam>.size());
}

}  // namespace
}  // namespace slam::choices_test
