// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/edit_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::edit_json_test {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& json) {
  return test::refusalOf([&] { editRequestOf(json); });
}

TEST(EditJson, ReadsAnEdit) {
  const EditRequest request = editRequestOf(
      R"({"kind": "place", "name": "dock", "by": "ada", "points": [[1, -2.5]], "theta": 0.5, "sigma": [0.1, 0.1, 0.05], "force": true})");
  EXPECT_EQ(request.kind, EditKind::kPlace);
  EXPECT_EQ(request.name, "dock");
  EXPECT_EQ(request.author, "ada");
  ASSERT_EQ(request.points.size(), 1U);
  EXPECT_EQ(request.points[0], Eigen::Vector2d(1.0, -2.5));
  EXPECT_EQ(request.theta, 0.5);
  EXPECT_EQ(request.sigma, Eigen::Vector3d(0.1, 0.1, 0.05));
  EXPECT_TRUE(request.force);
}

TEST(EditJson, RefusesWhatIsNoneWithAReason) {
  EXPECT_THAT(refusal(""), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal("[]"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal(R"({"kind": "free")"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal("{\"kind\": \"room\", \"name\": \"\xFF\"}"), HasSubstr("no JSON object"));  // no UTF-8
  EXPECT_THAT(refusal(R"({"points": []})"), HasSubstr("kind is missing"));
  EXPECT_THAT(refusal(R"({"kind": "paint"})"), HasSubstr("erase, free, wall, zone, room or place"));
  EXPECT_THAT(refusal(R"({"kind": "free", "points": [[1]]})"), HasSubstr("no [x, y]"));
  EXPECT_THAT(refusal(R"({"kind": "free", "points": [["1", 2]]})"), HasSubstr("x is no number"));
  EXPECT_THAT(refusal(R"({"kind": "free", "corners": []})"), HasSubstr("corners"));
  EXPECT_THAT(refusal(std::string(100000, '[')), HasSubstr("no JSON object"));
}

TEST(EditJson, WritesWhatIsInEffect) {
  test::ChangingMap changing(4);
  MapEdits edits;
  int edit = 0;
  EditCommand command{
      .kind = EditCommand::kAdd,
      .request = editRequestOf(R"({"kind": "place", "name": "dock", "points": [[1, 2]], "theta": 0.5})"),
      .id = 0,
      .utime = 7};
  ASSERT_FALSE(edits.carryOut(command, changing.map.keyframes, changing.map.in_map, &edit));
  const std::string json = editsJson(edits, changing.map.keyframes, changing.map.in_map);
  EXPECT_THAT(json, HasSubstr(R"("name":"dock")"));
  EXPECT_THAT(json, HasSubstr(R"("utime":7)"));
  command.kind = EditCommand::kUndo;
  ASSERT_FALSE(edits.carryOut(command, changing.map.keyframes, changing.map.in_map, &edit));
  EXPECT_EQ(editsJson(edits, changing.map.keyframes, changing.map.in_map), "[]");
}

}  // namespace
}  // namespace slam::edit_json_test
