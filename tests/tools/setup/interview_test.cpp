// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/interview.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "tools/files.hpp"
#include "tools/slamctl/setup/terminal_console.hpp"

namespace slam::interview_test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(SettingLine, PutsQuotesAroundWhatTomlTakesForNoValue) {
  EXPECT_EQ(settingLine("lidar.port", "/dev/ttyUSB0"), "lidar.port = \"/dev/ttyUSB0\"");
  EXPECT_EQ(settingLine("lidar.port", "tcp://192.168.0.10:10940  # on the mast"),
            "lidar.port = \"tcp://192.168.0.10:10940\"");
  EXPECT_EQ(settingLine("lidar.port", "a\"b\\c"), "lidar.port = \"a\\\"b\\\\c\"");
  EXPECT_EQ(settingLine("lidar.x", "0.1"), "lidar.x = 0.1");
  EXPECT_EQ(settingLine("lidar.x", "-.1"), "lidar.x = -0.1");
  EXPECT_EQ(settingLine("lidar.x", "1."), "lidar.x = 1.0");
  EXPECT_EQ(settingLine("lidar.mask", "[[1, 2]]"), "lidar.mask = [[1, 2]]");
  EXPECT_EQ(settingLine("lidar.upside_down", "true"), "lidar.upside_down = true");
  EXPECT_EQ(settingLine("lcm.url", ""), "lcm.url = \"\"");
}

class Asked : public testing::Test {
 protected:
  Interview& with(const std::string& typed, const std::vector<std::string>& set = {}) {
    in_.str(typed);
    in_.clear();
    out_.str("");
    return interview_.emplace(Config(), set, console_.emplace(&in_, out_));
  }
  test::Folder folder_;
  std::istringstream in_;
  std::ostringstream out_;
  std::optional<TerminalConsole> console_;
  std::optional<Interview> interview_;
};

TEST_F(Asked, TakesAnswersOverWhatIsFound) {
  Interview& interview = with("");
  interview.readAnswers(folder_.write("answers",
                                      "# Anna's robot\n\nlidar.x = .1   # by ruler\nbase.driver = kobuki\n"
                                      "lidar.port = '/dev/front'\n"));
  EXPECT_EQ(interview.config().front_end.lidar.T_base_lidar.x, 0.1);
  EXPECT_EQ(interview.valueOf("lidar.port"), "\"/dev/front\"");
  interview.take("base.driver", "create");
  EXPECT_EQ(interview.config().base_device.driver, BaseDriver::kKobuki);
  interview.ask("lidar.x", "where");
  EXPECT_TRUE(out_.str().empty()) << "what is answered is not asked";
}

TEST_F(Asked, RefusesAnUnknownAnswerWithItsLine) {
  Interview& interview = with("");
  const auto refusal = test::refusalOf(
      [&] { interview.readAnswers(folder_.write("answers", "lidar.y = 1\nlidar.prot = /dev/x\nlidar.x = far\n")); });
  EXPECT_THAT(refusal, HasSubstr("answers:2:"));
  EXPECT_THAT(refusal, HasSubstr("did you mean 'port'?"));
  EXPECT_THAT(refusal, HasSubstr("answers:3:")) << "all at once";
  EXPECT_FALSE(interview.isSet("lidar.y")) << "all or nothing";
  EXPECT_THAT(test::refusalOf([&] { interview.readAnswers(folder_.write("words", "hello\n")); }), HasSubstr("words:1"));
}

TEST_F(Asked, AsksAgainAfterAValueThatCannotBe) {
  Interview& interview = with("far\n99\n0.2\n");
  interview.ask("lidar.x", "How far ahead?");
  EXPECT_EQ(interview.config().front_end.lidar.T_base_lidar.x, 0.2);
  EXPECT_THAT(out_.str(), HasSubstr("How far ahead? (lidar.x) [0.0] "));
  EXPECT_THAT(out_.str(), HasSubstr("99 is out of range"));
  interview.ask("lidar.y", "How far left?");  // the input has ended
  EXPECT_EQ(interview.config().front_end.lidar.T_base_lidar.y, 0.0);
  EXPECT_FALSE(interview.hasPerson());
}

TEST_F(Asked, TakesTheDefaultOfAnEmptyLineAndKeepsWhatTheFileSets) {
  Interview& interview = with("\ny\nno\n", {"lidar.yaw"});
  interview.ask("lidar.yaw", "Yaw?");
  EXPECT_TRUE(out_.str().empty());
  interview.ask("lidar.x", "How far ahead?");
  EXPECT_EQ(interview.config().front_end.lidar.T_base_lidar.x, 0.0);
  EXPECT_TRUE(interview.agrees("write", "Write it?", false));
  EXPECT_FALSE(interview.agrees("write", "Write it?", true));
}

TEST(Interview, TakesDefaultsWhereNobodyCanBeAsked) {
  std::ostringstream out;
  TerminalConsole console(nullptr, out);
  Interview interview({}, {}, console);
  interview.ask("lidar.x", "How far ahead?");
  EXPECT_THAT(out.str(), HasSubstr("lidar.x = 0.0, a default"));
  EXPECT_FALSE(interview.isSet("lidar.x"));
  EXPECT_TRUE(interview.agrees("write", "Write it?", true));
  EXPECT_GT(interview.choose("lidar.port", "Which one?", {"a"}), 1U);
}

}  // namespace
}  // namespace slam::interview_test
