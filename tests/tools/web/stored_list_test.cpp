// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/stored_list.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace slam::stored_list_test {
namespace {

TEST(StoredList, IsReadNoMoreOftenThanItsAge) {
  int reads = 0;
  const StoredList list("/maps", [&](const std::filesystem::path& folder) {
    return nlohmann::json{folder.string(), ++reads};
  });
  constexpr Timestamp kStart{Duration(1)};
  EXPECT_EQ(list.text(kStart), R"(["/maps",1])");
  EXPECT_EQ(list.text(kStart + StoredList::kAge - Duration(1)), R"(["/maps",1])");
  EXPECT_EQ(list.text(kStart + StoredList::kAge), R"(["/maps",2])");
  list.forget();
  EXPECT_EQ(list.text(kStart + StoredList::kAge), R"(["/maps",3])");
}

TEST(StoredList, IsReadAgainWhereItCouldNotBe) {
  bool fails = true;
  const StoredList list("/maps", [&](const std::filesystem::path&) {
    return fails ? throw std::runtime_error("no such folder") : nlohmann::json::array();
  });
  EXPECT_THROW(list.text({}), std::runtime_error);
  fails = false;
  EXPECT_EQ(list.text({}), "[]");
  EXPECT_TRUE(list.isThere());
  EXPECT_FALSE(StoredList("", nullptr).isThere());
}

}  // namespace
}  // namespace slam::stored_list_test
