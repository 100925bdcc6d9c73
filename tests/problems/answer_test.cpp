// SPDX-License-Identifier: BSD-3-Clause
#include "problems/answer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "problems/answers.hpp"
#include "problems/daemon.hpp"

namespace slam::answer_test {
namespace {

TEST(Answer, IsOneSentenceOfItsRowsAndTheRows) {
  const Problem disk{problem::kDiskFull, {}, {"/maps", "", " (12 MB)"}};
  const Answer answer = answerOf({{answer::kLoaded, {}, {"house"}}, answer::kOldMapNotStored, disk});
  EXPECT_EQ(answer.words,
            "loaded house; looking for the robot in it; the one before is not stored: no space on /maps (12 MB): make "
            "room: sudo du -sh /maps/*; slamctl log list");
  ASSERT_EQ(answer.parts.size(), 3U);
  EXPECT_TRUE(answer.parts[0].is(answer::kLoaded));
  EXPECT_TRUE(answer.parts[1].is(answer::kOldMapNotStored));
  EXPECT_EQ(answer.parts[2], disk);
}

TEST(Answer, LeavesOutWhatIsNoProblem) {
  const Answer answer = answerOf({answer::kNewMap, Problem(), Problem()});
  EXPECT_EQ(answer.words, "a new map begins");
  EXPECT_EQ(answer.parts.size(), 1U);
}

TEST(Answer, IsOfTheRowOfARefusal) {
  const CommandRefused refused({answer::kMapExists, {}, {"house"}});
  EXPECT_STREQ(refused.what(), "there is a map \"house\" already");
  const Answer bare = answerOf(refused), behind = answerOf(refused, answer::kNotMarked);
  ASSERT_EQ(bare.parts.size(), 1U);
  EXPECT_STREQ(bare.parts[0].id(), "map_exists");
  EXPECT_EQ(behind.words, "not marked: there is a map \"house\" already");
  EXPECT_EQ(behind.parts.size(), 2U);
}

TEST(Answer, IsWordsAloneOfAnyOtherError) {
  const std::string path(2 * Problem::kTextSize, 'x');  // no row could hold it
  const Answer answer = answerOf(std::runtime_error(path + ": is damaged"), answer::kNotMarked);
  EXPECT_EQ(answer.words, "not marked: " + path + ": is damaged");
  EXPECT_TRUE(answer.parts.empty());
}

}  // namespace
}  // namespace slam::answer_test
