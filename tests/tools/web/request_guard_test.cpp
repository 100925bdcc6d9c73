// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/request_guard.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace slam::request_guard_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Optional;

TEST(HostOf, TakesNamesAndAddressesWithAndWithoutPort) {
  EXPECT_THAT(hostOf("localhost"), Optional(std::string("localhost")));
  EXPECT_THAT(hostOf("Robot.local:8080"), Optional(std::string("robot.local")));
  EXPECT_THAT(hostOf("192.168.1.7:1"), Optional(std::string("192.168.1.7")));
  EXPECT_THAT(hostOf("[::1]:8080"), Optional(std::string("::1")));
  EXPECT_THAT(hostOf("[fe80::1]"), Optional(std::string("fe80::1")));
}

TEST(HostOf, RefusesWhatIsNone) {
  for (const char* header :
       {"", ":8080", "localhost:", "localhost:http", "localhost:123456", "a b", "[::1", "[]", "[::1]8080",
        "[localhost]", "user@localhost", "localhost/", "localhost:80:80", "a\tb", "caf\xc3\xa9"}) {
    EXPECT_FALSE(hostOf(header)) << header;
  }
  EXPECT_FALSE(hostOf(std::string("localhost\0.evil", 15)));
  EXPECT_FALSE(hostOf(std::string(300, 'a')));
}

TEST(OwnNames, AreThoseOfThisComputer) {
  char name[256] = {};
  ASSERT_EQ(gethostname(name, sizeof name - 1), 0);
  const auto names = ownNames("Robot7");
  EXPECT_THAT(names, testing::IsSupersetOf({"localhost", "127.0.0.1", "::1", "robot7"}));
  EXPECT_THAT(names, Contains(testing::StrCaseEq(name)));
  EXPECT_THAT(ownNames("0.0.0.0"), testing::Not(Contains("0.0.0.0"))) << "an address of anybody's";
}

TEST(Secret, IsTheSameOnlyAsAWhole) {
  EXPECT_TRUE(isSameSecret("correct horse", "correct horse"));
  for (const char* given :
       {"", "correct", "correct horse ", "correct horsf", "Correct horse", "correct horsecorrect horse"}) {
    EXPECT_FALSE(isSameSecret(given, "correct horse")) << given;
  }
  EXPECT_FALSE(isSameSecret("", "")) << "no secret lets nobody in";
}

TEST(Bearer, IsTakenFromItsSchemeAlone) {
  EXPECT_EQ(bearerOf("Bearer abc"), "abc");
  EXPECT_EQ(bearerOf("Basic abc"), "");
  EXPECT_EQ(bearerOf("Bearer"), "");
  EXPECT_EQ(bearerOf(""), "");
}

TEST(VersionOf, IsAWholeNumber) {
  EXPECT_THAT(versionOf("0"), Optional(0U));
  EXPECT_THAT(versionOf("123456"), Optional(123456U));
  for (const char* text : {"", "-1", "1.5", "1 ", " 1", "0x10", "9007199254740992", "99999999999999999999"})
    EXPECT_FALSE(versionOf(text)) << text;
}

TEST(LogPathOf, IsARunAndAFile) {
  EXPECT_THAT(logPathOf("/logs/"), Optional(testing::IsEmpty()));
  EXPECT_THAT(logPathOf("/logs/2026-01-02T03-04-05_ab12"), Optional(ElementsAre("2026-01-02T03-04-05_ab12")));
  EXPECT_THAT(logPathOf("/logs/run/0001.lcm.gz"), Optional(ElementsAre("run", "0001.lcm.gz")));
  EXPECT_THAT(logPathOf("/logs/run/"), Optional(ElementsAre("run")));
}

TEST(LogPathOf, LeadsNowhereElse) {
  for (const char* path :
       {"/logs", "/log/run", "/logs/..", "/logs/../etc", "/logs/run/..", "/logs/run/../..", "/logs/.hidden",
        "/logs//etc", "/logs/a/b/c", "/logs/a\\b", "/logs/a b", "/logs/~", "/logs/%2e%2e", "/logs/a\n"}) {
    EXPECT_FALSE(logPathOf(path)) << path;
  }
  EXPECT_FALSE(logPathOf(std::string("/logs/a\0b", 9)));
  EXPECT_FALSE(logPathOf("/logs/" + std::string(1000, 'a')));
}

TEST(CommandOf, TakesThoseOfThePage) {
  Answer problem;
  const auto save = commandOf(R"({"verb":"save","name":"kitchen"})", problem);
  ASSERT_TRUE(save) << problem.words;
  EXPECT_EQ(save->argument, "kitchen");
  EXPECT_TRUE(commandOf(R"({"verb":"save"})", problem));
  const auto pose = commandOf(R"({"verb":"set_pose","x":1.5,"y":-2,"theta":0.25})", problem);
  ASSERT_TRUE(pose) << problem.words;
  EXPECT_THAT(pose->pose, ElementsAre(1.5, -2.0, 0.25));
  const auto mark = commandOf(R"({"verb":"log_mark","text":"hit the door"})", problem);
  ASSERT_TRUE(mark) << problem.words;
  EXPECT_EQ(mark->argument, "hit the door");
  const auto mode = commandOf(R"({"verb":"mode","mode":"localise"})", problem);
  ASSERT_TRUE(mode) << problem.words;
  EXPECT_EQ(mode->argument, "localise");
}

TEST(CommandOf, ReportsWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "JSON"},
      {"[]", "JSON"},
      {"{", "JSON"},
      {R"({"verb":"reset"})", "unknown verb"},
      {R"({"verb":"mode","mode":"drive"})", "not localise or slam"},
      {R"({"verb":7})", "unknown verb"},
      {R"({"verb":"save","name":"../../etc"})", "name"},
      {R"({"verb":"save","name":"a\u0000b"})", "name"},
      {R"({"verb":"set_pose","x":1,"y":2})", "three numbers"},
      {R"({"verb":"set_pose","x":1,"y":2,"theta":1e300})", "theta = 1e+300 rad is more than a full turn"},
      {R"({"verb":"set_pose","x":1e6,"y":2,"theta":0})", "x = 1e+06 m is more than 10 km"},
      {R"({"verb":"set_pose","x":1,"y":-1e155,"theta":0})", "y = -1e+155 m is more than 10 km"},
      {R"({"verb":"set_pose","x":"1","y":2,"theta":0})", "three numbers"},
      {R"({"verb":"log_mark"})", "one line"},
      {R"({"verb":"log_mark","text":"a\nb"})", "one line"},
      {R"({"verb":"log_mark","text":"a\u0000b"})", "one line"}};
  for (const auto& [body, words] : cases) {
    Answer problem;
    EXPECT_FALSE(commandOf(body, problem)) << body;
    EXPECT_THAT(problem.words, HasSubstr(words)) << body;
  }
}

}  // namespace
}  // namespace slam::request_guard_test
