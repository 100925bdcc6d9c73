// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/history/history_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tools/files.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam::history_file_test {
namespace {

using testing::HasSubstr;
constexpr std::int64_t kStart = 1'700'000'000'000'000, kSecond = 1'000'000;

pose_estimate_t poseAt(std::int64_t utime, int state) {
  pose_estimate_t pose{};
  pose.utime = utime;
  pose.state = static_cast<std::int8_t>(state);
  return pose;
}

/// Localised, lost for a reason, and a mark.
DayHistory sample() {
  DayHistory history;
  history.take(poseAt(kStart, 1));
  history.take(poseAt(kStart + kSecond, 3));
  health_t health{};
  health.utime = kStart + kSecond;
  problems_t problems{};
  problems.problems.resize(1);
  problems.problems[0].device = "pose", problems.problems[0].id = "lost";
  problems.problems[0].level = 2, problems.problems[0].numbers = {0.25}, problems.problems[0].texts = {"home"};
  history.take(health, problems);
  history.mark("here");
  history.take(poseAt(kStart + 2 * kSecond, 3));
  return history;
}

TEST(HistoryFile, KeepsTheDayOverTheEndOfTheProgram) {
  const test::Folder folder;
  const HistoryFile file(folder / ".");
  EXPECT_FALSE(file.read());
  file.write(DayHistory());
  EXPECT_FALSE(file.read()) << "nothing came yet";
  file.write(sample());
  file.write(sample());  // in place of the first
  const auto read = file.read();
  ASSERT_TRUE(read);
  EXPECT_EQ(historyJson(*read), historyJson(sample()));
}

TEST(HistoryFile, GoesOnWhereItEnded) {
  const test::Folder folder;
  const HistoryFile file(folder / ".");
  file.write(sample());
  DayHistory history = *file.read();
  const std::size_t before = history.all().size();
  history.take(poseAt(kStart + 3600 * kSecond, 1));
  EXPECT_EQ(history.all().size(), before + 1) << "an hour that nobody watched is neither silent nor lost";
  EXPECT_EQ(history.since(), kStart);
  for (int i = 0; i < 2; ++i) history.take(poseAt(kStart + 2 * DayHistory::kPeriod + i * kSecond, 1));
  EXPECT_GT(history.all().front().end, kStart + DayHistory::kPeriod) << "what was read ages, too";
}

TEST(HistoryFile, RefusesWhatCannotBe) {
  const test::Folder folder;
  const HistoryFile file(folder / ".");
  const auto good = historyJson(sample());
  const auto refusalOf = [&](const auto& change) {
    auto json = good;
    change(json);
    folder.write("history.json", textOf(json));
    return test::refusalOf([&] { file.read(); });
  };
  using Json = nlohmann::json;
  EXPECT_EQ(refusalOf([](Json&) {}), "") << "the sample itself";
  EXPECT_THAT(refusalOf([](Json& j) { j = "words"; }), HasSubstr("history.json: it is damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["since"] = -1; }), HasSubstr("damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["now"] = 1e300; }), HasSubstr("damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["happenings"][0]["kind"] = "other"; }), HasSubstr("damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["happenings"][0].erase("x"); }), HasSubstr("damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["happenings"][0]["end"] = 1; }), HasSubstr("damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["happenings"][0]["name"] = std::string(5000, 'a'); }), HasSubstr("damaged"));
  EXPECT_THAT(refusalOf([](Json& j) { j["happenings"] = Json(std::vector<Json>(4000, j["happenings"][0])); }),
              HasSubstr("damaged"));
  folder.write("history.json", "{");
  EXPECT_THAT(test::refusalOf([&] { file.read(); }), HasSubstr("damaged"));
}

TEST(HistoryFile, KeepsNothingWithoutAFolder) {
  const HistoryFile file({});
  file.write(sample());
  EXPECT_FALSE(file.read());
}

}  // namespace
}  // namespace slam::history_file_test
