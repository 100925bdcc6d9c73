// SPDX-License-Identifier: BSD-3-Clause
#include "config/loader.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "build_paths.hpp"
#include "config/config_values.hpp"

namespace slam::loader_test {
namespace {

using test::differences;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::StartsWith;

/// The lines of the refusal; empty when the text is accepted.
std::vector<std::string> problemsOf(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parseConfig(text, "robot.toml", overrides);
    return {};
  } catch (const ConfigError& error) {
    std::vector<std::string> lines(1);
    for (const char* c = error.what(); *c != 0; ++c) {
      if (*c == '\n') {
        lines.emplace_back();
      } else {
        lines.back() += *c;
      }
    }
    if (lines.back().empty()) lines.pop_back();
    return lines;
  }
}

/// A text with one bad value and what its refusal begins with.
struct BadText {
  const char* what;
  const char* text;
  const char* place;
};
void PrintTo(const BadText& bad, std::ostream* out) { *out << bad.what; }

class RefusedText : public testing::TestWithParam<BadText> {};

TEST_P(RefusedText, IsNamedWithItsPlace) {
  EXPECT_THAT(problemsOf(GetParam().text), ElementsAre(StartsWith(GetParam().place))) << GetParam().text;
}

INSTANTIATE_TEST_SUITE_P(
    ParseConfig, RefusedText,
    testing::Values(BadText{"UnknownKey", "[lidar]\n  range_mux = 3.0\n", "robot.toml:2:"},
                    BadText{"UnknownSection", "[lidr]\nx = 1.0\n", "robot.toml:1:"},
                    BadText{"KeyOutsideOfSections", "range_max = 3.0\n", "robot.toml:1:"},
                    BadText{"TextForNumber", "[lidar]\nrange_max = \"3\"\n", "robot.toml:2:"},
                    BadText{"BooleanForNumber", "[lidar]\nrange_max = true\n", "robot.toml:2:"},
                    BadText{"FractionForInteger", "[lidar]\nbaud = 115200.5\n", "robot.toml:2:"},
                    BadText{"NumberForBoolean", "[lcm]\ncommands = 1\n", "robot.toml:2:"},
                    BadText{"NumberForText", "[lidar]\nport = 1\n", "robot.toml:2:"},
                    BadText{"ListForNumber", "[lidar]\nrange_max = [3.0]\n", "robot.toml:2:"},
                    BadText{"TableForNumber", "[lidar.range_max]\nx = 3.0\n", "robot.toml:1:"},
                    BadText{"NumberForSection", "lidar = 3\n", "robot.toml:1:"},
                    BadText{"ListOfSections", "[[lidar]]\nrange_max = 3.0\n", "robot.toml:1:"},
                    BadText{"UnknownChoice", "[lidar]\ndriver = \"usb\"\n", "robot.toml:2:"},
                    BadText{"TooLarge", "[lidar]\nrange_max = 201\n", "robot.toml:2:"},
                    BadText{"TooSmall", "[lidar]\nrange_max = -1.0\n", "robot.toml:2:"},
                    BadText{"NaN", "[lidar]\nrange_max = nan\n", "robot.toml:2:"},
                    BadText{"NegativeNaN", "[lidar]\nrange_max = -nan\n", "robot.toml:2:"},
                    BadText{"Infinity", "[lidar]\nrange_max = inf\n", "robot.toml:2:"},
                    BadText{"NegativeInfinity", "[lidar]\nx = -inf\n", "robot.toml:2:"},
                    BadText{"IntegerThatWrapsAround", "[lidar]\nbaud = 4295082496\n", "robot.toml:2:"},
                    BadText{"IntegerBeyond64Bits", "[lidar]\nbaud = 99999999999999999999\n", "robot.toml:2:"},
                    BadText{"KeyTwice", "[lidar]\nx = 1.0\nx = 2.0\n", "robot.toml:3:"},
                    BadText{"HeaderWithoutKey", "[/F", "robot.toml:1:"},
                    BadText{"HeaderOfThreeBrackets", "[[[lidar]]]\n", "robot.toml:1:"},
                    BadText{"BrokenSyntax", "[lidar]\nrange_max == 3\n", "robot.toml:2:"},
                    BadText{"InvalidUtf8", "[lidar]\nport = \"\xff\xfe\"\n", "robot.toml:2:"}),
    [](const auto& test) { return std::string(test.param.what); });

TEST(ParseConfig, GivesTheDefaultsForAnEmptyText) {
  EXPECT_THAT(differences(parseConfig("", "robot.toml"), Config{}), IsEmpty());
}

TEST(ParseConfig, ChangesWhatTheTextNamesAndNothingElse) {
  const Config config =
      parseConfig("[lidar]\nrange_max = 8.5\ndriver = \"lcm\"\n[lcm]\ncommands = true\n", "robot.toml");
  EXPECT_EQ(config.front_end.lidar.range_max, 8.5);
  EXPECT_EQ(config.lidar_device.driver, LidarDriver::kLcm);
  EXPECT_TRUE(config.lcm.commands);
  EXPECT_THAT(differences(config, Config{}), ElementsAre("lcm.commands", "lidar.driver", "lidar.range_max"));
}

TEST(ParseConfig, ReadsTheLidarsMaskAndNamesWhatIsNone) {
  const Config config = parseConfig("[lidar]\nmask = [[150, 210.5], [-10, 10]]", "test");
  EXPECT_EQ(config.front_end.lidar.mask, (std::vector<BearingRange>{{150.0, 210.5}, {-10.0, 10.0}}));
  for (const char* wrong : {"150", "[150, 210]", "[[150]]", "[[210, 150]]", "[[0, 400]]", "[['a', 'b']]"})
    EXPECT_THROW(parseConfig(std::string("[lidar]\nmask = ") + wrong, "test"), ConfigError) << wrong;
}

TEST(ParseConfig, TakesAnIntegerForANumber) {
  EXPECT_EQ(parseConfig("[lidar]\nrange_max = 8\n", "robot.toml").front_end.lidar.range_max, 8.0);
}

TEST(ParseConfig, TakesAKeyUnderItsOldNameAndNamesTheNewOne) {
  const Config config =
      parseConfig("mode = \"slam\"\n[keyframe]\nfamiliarity = 0.5\n", "robot.toml", {"relocalisation.min_lead=9.0"});
  EXPECT_EQ(config.front_end.keyframe.known_ratio, 0.5);
  EXPECT_EQ(config.back_end.relocalisation.places.min_margin, 9.0);
  EXPECT_THAT(config.notices,
              ElementsAre(MatchesRegex("robot.toml:3:15: keyframe.familiarity: is called keyframe.known_ratio now; .*"),
                          HasSubstr("relocalisation.min_lead: is called relocalisation.min_margin now")));
}

TEST(ParseConfig, RefusesAKeyUnderBothNames) {
  EXPECT_THAT(problemsOf("[keyframe]\nfamiliarity = 0.5\nknown_ratio = 0.6\n"),
              ElementsAre(HasSubstr("keyframe.familiarity: is set under its new name, too; remove the old one")));
}

TEST(ParseConfig, RangesHoldUnderAnOldName) {
  EXPECT_THAT(problemsOf("[keyframe]\nfamiliarity = 1.5\n"), ElementsAre(StartsWith("robot.toml:2:15: ")));
}

TEST(ParseConfig, TakesKeysOfEarlierReleasesAndReportsThatTheyDoNothing) {
  const Config config =
      parseConfig("mode = \"slam\"\n[search]\nmax_doubt = 4.0\n", "robot.toml", {"search.max_doubt=\"anything\""});
  EXPECT_THAT(differences(config, Config{}), IsEmpty());
  EXPECT_THAT(config.notices,
              ElementsAre(MatchesRegex("robot.toml:3:13: search.max_doubt: has no effect any more, .*; remove it"),
                          HasSubstr("--set search.max_doubt=\"anything\":1:")));
  EXPECT_THAT(parseConfig("[search]\ntranslation = 0.4\n", "robot.toml").notices, IsEmpty());
}

TEST(Schema, HasNoKeyThatIsRetired) {
  const auto values = test::valuesOf(Config{});
  for (const RetiredKey& key : retiredKeys()) {
    EXPECT_EQ(values.count(std::string(key.section) + "." + key.key), 0U) << key.key;
  }
}

TEST(ParseConfig, TakesTheEndsOfARange) {
  EXPECT_THAT(problemsOf("[lidar]\nrange_max = 200.0\nx = -5.0\ny = 5\nbaud = 9600\n"), IsEmpty());
}

TEST(ParseConfig, TakesACameraOfUnknownHeightButNoneInTheFloor) {
  EXPECT_THAT(problemsOf("[depth]\nz = 0.0\n"), IsEmpty());
  EXPECT_THAT(problemsOf("[depth]\nz = 0.04\n"), ElementsAre(HasSubstr("depth.floor_clearance")));
}

TEST(ParseConfig, ReadsLineEndsOfWindows) { EXPECT_THAT(problemsOf("[lidar]\r\nrange_max = 8.5\r\n"), IsEmpty()); }

TEST(ParseConfig, AsksDidYouMean) {
  EXPECT_THAT(problemsOf("[lidar]\nrange_mux = 3.0\n"),
              ElementsAre(AllOf(HasSubstr("did you mean"), HasSubstr("range_max"))));
  EXPECT_THAT(problemsOf("[lidr]\n"), ElementsAre(AllOf(HasSubstr("did you mean"), HasSubstr("lidar"))));
}

TEST(ParseConfig, ShowsHowToMendAValue) {
  EXPECT_THAT(problemsOf("[lidar]\nrange_max = 201.0\n"),
              ElementsAre(AllOf(HasSubstr("0.5"), HasSubstr("200"), HasSubstr("lidar.range_max"))));
  EXPECT_THAT(problemsOf("[lidar]\ndriver = \"usb\"\n"), ElementsAre(AllOf(HasSubstr("rplidar"), HasSubstr("lcm"))));
}

TEST(ParseConfig, RefusesAnLcmUrlThatCannotWork) {
  for (const char* url :
       {"", "memq://", "tcpq://localhost:7700", "udpm://robot:7667", "udpm://239.255.76.67:7667?ttl=x"}) {
    EXPECT_THAT(problemsOf("[lcm]\nurl = \"" + std::string(url) + "\"\n"),
                ElementsAre(AllOf(HasSubstr("lcm.url"), HasSubstr(url), HasSubstr("use udpm://ADDRESS:PORT?ttl=0"))));
  }
}

TEST(ParseConfig, RefusesAPathThatIsTooLongForASocket) {
  EXPECT_THAT(problemsOf("[runtime]\nsocket = \"/" + std::string(106, 'x') + "\"\n"), testing::IsEmpty());
  EXPECT_THAT(
      problemsOf("[runtime]\nsocket = \"/" + std::string(107, 'x') + "\"\n"),
      ElementsAre(AllOf(StartsWith("robot.toml:2:"), HasSubstr("runtime.socket: is longer than the 107 bytes"))));
}

TEST(ParseConfig, RefusesATokenOfTheWebThatCanBeGuessed) {
  for (const char* what : {"commands = true", "read = \"token\""}) {
    EXPECT_THAT(problemsOf("[web]\n" + std::string(what) + "\ntoken = \"short\"\n"),
                ElementsAre(AllOf(HasSubstr("web.token"), HasSubstr("openssl rand"))));
    EXPECT_THAT(problemsOf("[web]\n" + std::string(what) + "\n"), IsEmpty()) << "it is in web.token_file";
  }
  EXPECT_THAT(problemsOf("[web]\ncommands = true\ntoken = \"0123456789ab\"\n"), IsEmpty());
  EXPECT_THAT(problemsOf("[web]\ntoken = \"short\"\n"), IsEmpty());
}

TEST(ParseConfig, NamesAllProblemsAtOnceInTheOrderOfTheFile) {
  auto problems = problemsOf(
      "[lidar]\n"
      "range_mux = 3.0\n"
      "baud = \"fast\"\n"
      "x = nan\n"
      "[nonsense]\n"
      "[lcm]\n"
      "pose_rate = 1e9\n");
  std::vector<std::string> places;
  for (const std::string& problem : problems) places.push_back(problem.substr(0, sizeof("robot.toml:2") - 1));
  EXPECT_THAT(places, testing::UnorderedElementsAre("robot.toml:2", "robot.toml:3", "robot.toml:4", "robot.toml:5",
                                                    "robot.toml:7"));
  EXPECT_THAT(problems, testing::Each(MatchesRegex("robot\\.toml:[0-9]+:[0-9]+: [a-z_.]+: .+; .+")));
}

TEST(Overrides, AreAppliedOverTheFile) {
  const Config config = parseConfig("[lidar]\nrange_max = 8.0\n", "robot.toml",
                                    {"lidar.range_max=9.5", "lcm.commands=true", "lidar.baud=256000"});
  EXPECT_EQ(config.front_end.lidar.range_max, 9.5);
  EXPECT_TRUE(config.lcm.commands);
  EXPECT_EQ(config.lidar_device.baud, 256000);
}

TEST(Overrides, TakeText) {
  const Config config =
      parseConfig("", "robot.toml", {R"(lidar.port="/dev/tty lidar")", R"(lcm.url="udpm://239.255.76.68:7667?ttl=1")"});
  EXPECT_EQ(config.lidar_device.port, "/dev/tty lidar");
  EXPECT_EQ(config.lcm.url, "udpm://239.255.76.68:7667?ttl=1");
}

TEST(Overrides, AreCheckedLikeTheFileAndTogetherWithIt) {
  for (const char* bad :
       {"lidar.range_mux=3", "lidar.range_max=far", "lidar.range_max=1e9", "lidar.range_max=nan", "lidar.range_max",
        "range_max=3", "lidar.range_max=", "=3", "", "nonsense.x=3", "lidar.baud=1]\n[lcm"}) {
    EXPECT_GE(problemsOf("", {bad}).size(), 1U) << "--set '" << bad << "'";
  }
  EXPECT_EQ(problemsOf("[lidar]\nrange_mux = 1.0\n", {"lidar.range_mix=3", "lidar.x=9"}).size(), 3U);
  EXPECT_THAT(problemsOf("", {"lidar.range_mux=3"}),
              ElementsAre(AllOf(HasSubstr("lidar.range_mux"), HasSubstr("range_max"))));
}

TEST(ParseConfig, PlacesAContradictionAtItsKeyBesideAllOtherProblems) {
  EXPECT_THAT(problemsOf("[lidar]\nrange_min = 6.0\nrange_max = 5.0\nrnge = 3\n"),
              testing::UnorderedElementsAre(HasSubstr("robot.toml:4:"),
                                            AllOf(HasSubstr("robot.toml:2:13: "), HasSubstr("lidar.range_min: "))));
  EXPECT_THAT(problemsOf("[lidar]\nrange_max = 5.0\n", {"lidar.range_min=6"}),
              ElementsAre(HasSubstr("--set lidar.range_min=6:1:")));
  EXPECT_THAT(problemsOf("[lidar]\nrange_min = 9.0\nrange_max = -1.0\n"), ElementsAre(HasSubstr("robot.toml:3:")))
      << "what is refused by itself contradicts nothing";
}

TEST(LoadConfig, TakesEveryFileOfTheRepository) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(SLAMD_SOURCE_DIR) / "config")) {
    if (entry.path().extension() != ".toml") continue;
    ++files;
    EXPECT_NO_THROW(loadConfig(entry.path())) << entry.path();
  }
  EXPECT_GE(files, 1);
}

TEST(LoadConfig, NamesTheFileInItsRefusal) {
  const std::string path = testing::TempDir() + "slamd_config_" + std::to_string(getpid()) + ".toml";
  std::ofstream(path) << "[lidar]\nrange_max = 1e9\n";
  try {
    loadConfig(path);
    ADD_FAILURE() << "not refused";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), StartsWith(path + ":2:"));
  }
  std::filesystem::remove(path);
}

TEST(LoadConfig, NamesTheGroupThatMayReadTheFile) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become somebody else";
  const std::string path = testing::TempDir() + "of_a_group_" + std::to_string(getpid()) + ".toml";
  std::ofstream(path) << "";
  const group* video = getgrnam("video");
  ASSERT_NE(video, nullptr);
  ASSERT_EQ(chown(path.c_str(), 0, video->gr_gid), 0);
  for (const mode_t mode : {0640, 0600}) {
    ASSERT_EQ(chmod(path.c_str(), mode), 0);
    const pid_t stranger = fork();
    if (stranger == 0) {
      constexpr int kNobody = 65534;
      if (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0) _exit(3);
      try {
        loadConfig(path);
        _exit(2);
      } catch (const ConfigError& error) {
        const std::string words = error.what();
        const bool caused = words.find("cannot read: Permission denied; ") != std::string::npos;
        const bool named = words.find("sudo usermod -aG video $USER") != std::string::npos;
        _exit(caused && named == (mode == 0640) ? 0 : 1);
      }
    }
    int status = 0;
    waitpid(stranger, &status, 0);
    EXPECT_EQ(status, 0) << mode;
  }
  std::filesystem::remove(path);
}

TEST(LoadConfig, RefusesAMissingFileByName) {
  try {
    loadConfig("/nonexistent/robot.toml");
    ADD_FAILURE() << "not refused";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nonexistent/robot.toml"));
  }
  EXPECT_THROW(loadConfig(testing::TempDir()), std::runtime_error) << "a folder";
}

}  // namespace
}  // namespace slam::loader_test
