// SPDX-License-Identifier: BSD-3-Clause
// The table itself, read as text: a row that is misspelt would be printed so in the field.
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <string>

#include "build_paths.hpp"

namespace slam::table_test {
namespace {

std::string table() {
  std::string text;
  for (const char* file : {"devices", "sensors", "daemon", "answers"}) {
    std::ifstream in(std::string(SLAMD_SOURCE_DIR "/daemon/problems/") + file + ".hpp");
    text.append(std::istreambuf_iterator<char>(in), {});
  }
  return text;
}

TEST(ProblemTable, HasAnIdOfItsOwnForEachRow) {
  const std::string text = table();
  const std::regex row(R"x(ProblemKind k\w+\{\s*"([^"]*)",)x");
  std::set<std::string> ids;
  for (std::sregex_iterator at(text.begin(), text.end(), row), end; at != end; ++at) {
    EXPECT_TRUE(ids.insert((*at)[1]).second) << (*at)[1];
    EXPECT_TRUE(std::regex_match((*at)[1].str(), std::regex("[a-z][a-z_]*"))) << (*at)[1];
  }
  EXPECT_GT(ids.size(), 150U);
}

TEST(ProblemTable, HasPlaceHoldersThatAProblemCanFill) {
  const std::string text = table();
  const std::regex literal("\"([^\"]*)\""), place(R"(\{(#[0-3](\.[0-9]|x[1-9]|s)?|[0-2])\})");
  for (std::sregex_iterator at(text.begin(), text.end(), literal), end; at != end; ++at) {
    const std::string rest = std::regex_replace((*at)[1].str(), place, "");
    EXPECT_EQ(rest.find_first_of("{}"), std::string::npos) << (*at)[1];
  }
}

}  // namespace
}  // namespace slam::table_test
