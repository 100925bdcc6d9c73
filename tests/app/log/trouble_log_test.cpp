// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/trouble_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/log_lines.hpp"
#include "problems/daemon.hpp"
#include "support/problems.hpp"

namespace slam::trouble_log_test {
namespace {

using namespace std::chrono_literals;
using test::LoggedLine;
using test::mostWithinAnHour;
using test::problemOf;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr Timestamp kBegin{1000s};

class Log : public testing::Test {
 protected:
  /// @param text that is wrong with the lidar then; empty: it is well
  std::vector<std::string> look(Duration at, const std::string& text) {
    std::vector<Trouble> present;
    if (!text.empty()) present.push_back({.device = "lidar", .problem = problemOf(text), .recovery = "lidar works"});
    return textsOf(log.look(present, kBegin + at));
  }
  static std::vector<std::string> textsOf(const std::vector<LogLine>& lines) {
    std::vector<std::string> texts;
    for (const LogLine& line : lines) texts.push_back(line.text);
    return texts;
  }
  TroubleLog log;
};

TEST_F(Log, HasANewReasonAtOnceAndRepeatsItEverMoreSeldom) {
  std::vector<int> minutes;
  for (int second = 0; second < 6 * 3600; second += 10) {
    if (!look(second * 1s, "no such port").empty()) minutes.push_back(second / 60);
  }
  EXPECT_THAT(minutes, ElementsAre(0, 1, 3, 7, 15, 31, 63, 123, 183, 243, 303));
}

TEST_F(Log, ReportsHowLongItHasLasted) {
  EXPECT_THAT(look(0s, "no such port"), ElementsAre("no such port"));
  EXPECT_THAT(look(60s, "no such port"), ElementsAre("no such port (for 1 min)"));
  EXPECT_THAT(look(10min, "no answer"), ElementsAre("no answer (for 10 min)"));
}

TEST_F(Log, TakesTwoReasonsInTurnForOneCause) {
  int lines = 0;
  for (int second = 0; second < 3600; ++second)
    lines += static_cast<int>(look(second * 1s, second % 2 == 0 ? "no data" : "no answer").size());
  EXPECT_EQ(lines, 2 + 5) << "each reason, and at minutes 1, 3, 7, 15 and 31";
}

TEST_F(Log, TakesFiguresForNoNews) {
  int lines = 0;
  for (int second = 0; second < 60; ++second)
    lines += static_cast<int>(
        log.look({{.device = "log", .problem = {problem::kLogNoRoom, {1.5 * second, 200.0}}}}, kBegin + second * 1s)
            .size());
  EXPECT_EQ(lines, 1);
}

TEST_F(Log, ReportsOnceThatACauseIsOverWhenItHasBeenWellForAWhile) {
  look(0s, "no data");
  EXPECT_THAT(look(10s, ""), IsEmpty());
  EXPECT_THAT(look(12s, "no data"), IsEmpty()) << "it was not over";
  EXPECT_THAT(look(14s, ""), IsEmpty());
  EXPECT_THAT(look(18900ms, ""), IsEmpty());
  EXPECT_THAT(look(19s, ""), ElementsAre("lidar works"));
  for (int second = 20; second < 4000; ++second) EXPECT_THAT(look(second * 1s, ""), IsEmpty());
  EXPECT_THAT(look(4001s, "no data"), ElementsAre("no data")) << "at once, an hour later";
}

TEST_F(Log, KeepsACauseOpenThatHasNoWordsNow) {
  look(0s, "no data");
  for (int second = 1; second < 50; ++second)
    EXPECT_THAT(log.look({{.device = "lidar"}}, kBegin + second * 1s), IsEmpty());
  EXPECT_TRUE(log.isOpen("lidar"));
  EXPECT_THAT(log.look({{.device = "base"}}, kBegin + 50s), IsEmpty());
  EXPECT_FALSE(log.isOpen("base"));
}

TEST_F(Log, CountsHowOftenACauseCameBack) {
  look(0s, "no data");
  look(10s, "");
  EXPECT_THAT(look(15s, ""), ElementsAre("lidar works"));
  EXPECT_THAT(look(30s, "no data"), IsEmpty()) << "within the first minute";
  look(40s, "");
  look(45s, "");
  EXPECT_THAT(look(61s, "no data"), ElementsAre("no data (3 times)"));
}

TEST_F(Log, DoesNotLeaveTheWrongStateForLong) {
  // Comes and goes until its interval is an hour, then stays away.
  Duration at = 0s;
  for (; at < 2h; at += 10s) look(at, at / 10s % 2 == 0 ? "no data" : "");
  look(at += 10s, ""), look(at += 10s, "");
  EXPECT_FALSE(log.isOpen("lidar"));
  std::optional<Duration> said;
  for (const Duration begin = at; !said && at < begin + 1h; at += 10s) {
    if (!look(at, "no data").empty()) said = at - begin;
  }
  EXPECT_LE(said.value_or(24h), 11min);
}

TEST_F(Log, HasTwentyLinesAnHourOfACauseWhateverItsWordsAndKeepsOneForTheRecovery) {
  int lines = 0;
  for (int i = 0; i < 100; ++i) lines += static_cast<int>(look(i * 1s, std::string("reason ") + char('A' + i)).size());
  EXPECT_EQ(lines, 15);
  look(100s, "");
  EXPECT_THAT(look(105s, ""), ElementsAre("lidar works"));
}

TEST_F(Log, HasEventsOnceAndCountsThoseThatItLeavesOut) {
  const auto happens = [&](Duration at) {
    const Problem late(problem::kThreadLate, {static_cast<double>(at.count() % 97)}, {"estimator"});
    return log.happened("estimator", late, late.words(), LogLine::kWarning, kBegin + at);
  };
  EXPECT_TRUE(happens(0s));
  EXPECT_FALSE(happens(1s));
  EXPECT_FALSE(happens(59s));
  const auto line = happens(60s);
  ASSERT_TRUE(line);
  EXPECT_THAT(line->text, testing::EndsWith("(and 2 times before)"));
  EXPECT_EQ(line->level, LogLine::kWarning);
  EXPECT_FALSE(happens(170s));
  EXPECT_TRUE(happens(180s));
}

/// What is wrong of one cause at a time of the day; nothing: it is well.
struct Course {
  const char* kind;
  Duration step;
  std::string (*at)(Duration);
};

void PrintTo(const Course& course, std::ostream* out) { *out << course.kind; }

std::string alternating(Duration at, Duration wrong, Duration well) {
  return at % (wrong + well) < wrong ? "no data" : "";
}

class Day : public testing::TestWithParam<Course> {};

TEST_P(Day, HasFewLines) {
  const Course& course = GetParam();
  TroubleLog log;
  std::vector<LoggedLine> lines;
  for (Duration at = 0s; at < 24h; at += course.step) {
    std::vector<Trouble> present;
    if (const std::string text = course.at(at); !text.empty())
      present.push_back({.device = "it", .problem = problemOf(text), .recovery = "well"});
    for (const LogLine& line : log.look(present, kBegin + at)) lines.push_back({at, line});
  }
  int recoveries = 0, well_before = 0;
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.front().at, Duration(0)) << "at once";
  for (const LoggedLine& line : lines) {
    const int is_well = line.line.level == LogLine::kInfo;
    EXPECT_FALSE(well_before && is_well) << "recovery is said once, at " << line.at / 1s << " s";
    well_before = is_well;
    recoveries += is_well;
  }
  EXPECT_LE(mostWithinAnHour(lines), 20);
  EXPECT_LT(lines.size(), 500U);
  std::printf("%-40s %3zu lines, %2d within an hour, %d of them recoveries\n", course.kind, lines.size(),
              mostWithinAnHour(lines), recoveries);
}

INSTANTIATE_TEST_SUITE_P(
    OfEachKindOfFault, Day,
    testing::Values(Course{"off", 1s, [](Duration) { return std::string("no such port"); }},
                    Course{"two reasons in turn, 62 a minute", 500ms,
                           [](Duration at) {
                             return std::string(at / 500ms % 2 == 0 ? "STALE: no data" : "FAULT: no answer");
                           }},
                    Course{"thirty reasons in turn", 1s,
                           [](Duration at) { return std::string("reason ") + static_cast<char>('A' + at / 1s % 30); }},
                    Course{"a new reason each second", 1s,
                           [](Duration at) {
                             std::string text = "reason ";
                             for (auto n = at / 1s; n > 0; n /= 26) text += static_cast<char>('a' + n % 26);
                             return text;
                           }},
                    Course{"intermittent, 0.7 s", 100ms, [](Duration at) { return alternating(at, 700ms, 700ms); }},
                    Course{"intermittent, 10 s", 1s, [](Duration at) { return alternating(at, 10s, 10s); }},
                    Course{"intermittent, a minute", 1s, [](Duration at) { return alternating(at, 1min, 1min); }},
                    Course{"intermittent, 11 minutes", 1s, [](Duration at) { return alternating(at, 11min, 11min); }},
                    Course{"a second each five minutes", 1s, [](Duration at) { return alternating(at, 1s, 299s); }},
                    Course{"well for a second each minute", 1s, [](Duration at) { return alternating(at, 59s, 1s); }},
                    Course{"each hour and a minute", 1s, [](Duration at) { return alternating(at, 30s, 3630s); }}));

}  // namespace
}  // namespace slam::trouble_log_test
