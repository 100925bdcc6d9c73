// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/maps/map_request.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slam/edits/edit_json.hpp"

namespace slam::map_request_test {
namespace {

using testing::HasSubstr;

TEST(MapRequest, IsSentAsSlamctlSendsIt) {
  const std::pair<const char*, std::pair<const char*, const char*>> cases[] = {
      {R"({"verb":"load","name":"house"})", {"load", "house"}},
      {R"({"verb":"delete","name":"house"})", {"delete", "house"}},
      {R"({"verb":"rename","name":"house","to":"home"})", {"rename", "house home"}},
      {R"({"verb":"restore"})", {"restore", ""}},
      {R"({"verb":"map_undo"})", {"map_undo", ""}},
      {R"({"verb":"map_redo"})", {"map_redo", ""}},
      {R"({"verb":"map_straighten"})", {"map_straighten", ""}},
      {R"({"verb":"map_remove","id":7})", {"map_remove", "7"}}};
  for (const auto& [body, wanted] : cases) {
    Answer problem;
    const auto command = commandOf(body, problem);
    ASSERT_TRUE(command) << body << ": " << problem.words;
    EXPECT_EQ(command->verb, wanted.first);
    EXPECT_EQ(command->argument, wanted.second);
  }
}

TEST(MapRequest, HasAnEditThatSlamdReads) {
  Answer problem;
  const auto command = commandOf(
      R"({"verb":"map_edit","edit":{"kind":"room","name":"Küche","points":[[0,0],[1,0],[1,1]],"by":"page"}})", problem);
  ASSERT_TRUE(command) << problem.words;
  EXPECT_EQ(command->verb, "map_edit");
  const EditRequest edit = editRequestOf(command->argument);
  EXPECT_EQ(edit.kind, EditKind::kRoom);
  EXPECT_EQ(edit.name, "Küche");
  EXPECT_EQ(edit.author, "page");
  EXPECT_EQ(edit.points.size(), 3U);
}

TEST(MapRequest, ReportsWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"verb":"load"})", "no name of a map"},
      {R"({"verb":"load","name":"../etc"})", "no name of a map"},
      {R"({"verb":"delete","name":"a b"})", "no name of a map"},
      {R"({"verb":"rename","name":"a"})", "\"to\" is no name"},
      {R"({"verb":"rename","name":"a","to":".deleted"})", "\".deleted\" is no name"},
      {R"({"verb":"map_remove","id":-1})", "no number of an edit"},
      {R"({"verb":"map_remove","id":"1"})", "no number of an edit"},
      {R"({"verb":"map_edit"})", "no JSON object"},
      {R"({"verb":"map_edit","edit":{"kind":"hole","points":[]}})", "kind is"},
      {R"({"verb":"map_edit","edit":{"kind":"zone","points":[[0,0],[1,1],[1,0],[0,1]]}})", "cross"},
      {R"({"verb":"map_edit","edit":{"kind":"zone","points":[[0,0],[1,1]]}})", "three corners"},
      {R"({"verb":"map_save"})", "unknown verb"}};
  for (const auto& [body, words] : cases) {
    Answer problem;
    EXPECT_FALSE(commandOf(body, problem)) << body;
    EXPECT_THAT(problem.words, HasSubstr(words)) << body;
  }
}

}  // namespace
}  // namespace slam::map_request_test
