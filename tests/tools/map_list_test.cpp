// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/map_list.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_list_test {
namespace {

TEST(MapList, HasEachMapWithItsStateAndTheOneThatIsContinued) {
  const test::Folder folder;
  for (const char* name : {"b", "a", "damaged"}) MapStore(folder / "", name).checkpoint(test::ChangingMap(6).map);
  MapStore(folder / "", "a").checkpoint(test::ChangingMap(6).map);
  std::filesystem::resize_file(folder / "damaged/000001/graph.bin", 3);
  const auto list = mapsJson(folder / "");
  ASSERT_EQ(list.size(), 3U);
  EXPECT_EQ(list[0]["name"], "a");
  EXPECT_EQ(list[0]["keyframes"], 6);
  EXPECT_EQ(list[0]["generation"], 2);
  EXPECT_EQ(list[0]["state"], "good");
  EXPECT_EQ(list[0]["continued_at_start"], true);
  EXPECT_EQ(list[1]["continued_at_start"], false);
  EXPECT_EQ(list[2]["state"], "damaged");
  EXPECT_NE(list[2]["problem"], "");
  testing::internal::CaptureStdout();
  printMaps(folder / "");
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::HasSubstr("* a "));
}

}  // namespace
}  // namespace slam::map_list_test
