// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/text/event_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bus/problem_message.hpp"
#include "problems/devices.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/web/map_tiles.hpp"

namespace slam::event_text_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
constexpr Timestamp kNow{Duration(100s)};

/// Names of the events in a text, and the data of the last of a name.
std::vector<std::string> namesIn(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("event: ")) names.push_back(line.substr(7));
  }
  return names;
}
json dataOf(const std::string& text, const std::string& name) {
  const auto at = text.rfind("event: " + name + "\ndata: ");
  if (at == std::string::npos) return {};
  const auto begin = at + 14 + name.size();
  return json::parse(text.substr(begin, text.find('\n', begin) - begin));
}

pose_estimate_t somePose(std::int64_t utime = 1'700'000'000'000'000) {
  pose_estimate_t pose{};
  pose.utime = utime;
  pose.map_id = 5;
  pose.x = 1.23456789;
  pose.covariance[0] = 0.01;
  pose.covariance[4] = 0.04;
  pose.state = 1;
  return pose;
}

health_t someHealth(const std::string& reason) {
  health_t health{};
  health.summary = "pose localised";
  health.ndevices = 1;
  device_health_t lidar{};
  lidar.name = "lidar";
  lidar.state = 3;
  lidar.reason = reason;
  lidar.age = 2.5;
  lidar.expected = 5.5;
  health.devices.push_back(lidar);
  return health;
}

class Feed : public testing::Test {
 protected:
  WebState state_{Config{}};
  EventFeed feed_{42, true, "1.2.3"};
};

TEST_F(Feed, GreetsWithAllThatIsKnown) {
  state_.begin(kNow);
  state_.take(somePose(), kNow);
  state_.take(someHealth("unplugged"), kNow);
  const std::string text = feed_.greeting(state_, kNow + 3s);
  EXPECT_THAT(namesIn(text), testing::ElementsAre("hello", "trail", "health", "pose", "map", "edits"));
  EXPECT_EQ(dataOf(text, "hello")["session"], 42);
  EXPECT_EQ(dataOf(text, "hello")["commands"], true);
  EXPECT_EQ(dataOf(text, "hello")["silence"], 3.0);
  EXPECT_EQ(dataOf(text, "pose")["state"], "localised");
  EXPECT_EQ(dataOf(text, "trail")["cm"], json({123, 0}));
}

TEST_F(Feed, SendsWhatIsNewOnce) {
  feed_.news(state_, kNow);
  state_.take(somePose(), kNow);
  EXPECT_THAT(namesIn(feed_.news(state_, kNow + 100ms)), testing::Contains("pose"));
  EXPECT_EQ(feed_.news(state_, kNow + 200ms), "");
  state_.take(someHealth(""), kNow);
  EXPECT_THAT(namesIn(feed_.news(state_, kNow + 300ms)), testing::ElementsAre("health"));
}

TEST_F(Feed, SendsABeatWithTheSilenceEachSecond) {
  state_.begin(kNow);
  int beats = 0;
  for (int i = 1; i <= 50; ++i) {
    const std::string text = feed_.news(state_, kNow + i * 100ms);
    if (text.find("event: beat") == std::string::npos) continue;
    ++beats;
    EXPECT_NEAR(dataOf(text, "beat")["silence"].get<double>(), 0.1 * i, 1e-6);
  }
  EXPECT_EQ(beats, 5);
}

TEST_F(Feed, NamesAChangeOfTheMapNoMoreThanTwiceASecond) {
  feed_.news(state_, kNow);
  state_.take(somePose(), kNow);
  int changes = 0;
  for (int i = 1; i <= 20; ++i) {
    state_.take(MapLayer::kBoth, test::noisyTile(5, 0, 0, static_cast<unsigned>(i)), kNow);
    changes += feed_.news(state_, kNow + i * 100ms).find("event: map") != std::string::npos;
  }
  EXPECT_GE(changes, 2);
  EXPECT_LE(changes, 5);
  const std::string last = feed_.news(state_, kNow + 10s);
  EXPECT_EQ(dataOf(last, "map")["version"], state_.tiles().version()) << "the last change is named, however early";
}

TEST(EventText, HasADevicesWordsAndAdvice) {
  const Problem silent(problem::kSilent);
  problems_t problems{};
  problems.problems = {toMessage("lidar", silent, true)};
  const json lidar = healthJson(someHealth("no data for 2.5 s, port present"), problems)["devices"][0];
  EXPECT_EQ(lidar["state"], "STALE");
  EXPECT_EQ(lidar["level"], "fault");
  EXPECT_EQ(lidar["reason"], "no data for 2.5 s, port present");
  EXPECT_EQ(lidar["advice"], silent.fix());
  const json problem = healthJson(someHealth(""), problems)["problems"][0];
  EXPECT_EQ(problem["id"], silent.id());
  EXPECT_EQ(problem["level"], "fault");
  EXPECT_EQ(problem["cause"], silent.cause());
}

TEST(EventText, StaysJsonAndOneLineWhateverAMessageHas) {
  const std::string text =
      eventText("health", healthJson(someHealth("\xff\xfe\n\nevent: pose\ndata: {}\r\n\x01\""), {}));
  EXPECT_THAT(namesIn(text), testing::ElementsAre("health"));
  EXPECT_NO_THROW(dataOf(text, "health"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << "a newline inside would end the data";
  pose_estimate_t pose = somePose();
  pose.state = 77;
  pose.covariance[0] = std::nan("");
  const json odd = json::parse(textOf(poseJson(pose)));
  EXPECT_EQ(odd["state"], "unknown");
  EXPECT_TRUE(odd["cov"][0].is_null());
}

TEST(EventText, PacksPointsIntoBase64OfCentimetres) {
  const json data = pointsJson({{10.0, -20.0}, {10.01, -20.02}, {9.0, -20.0}});
  EXPECT_EQ(data["x"], 1000);
  EXPECT_EQ(data["y"], -2000);
  EXPECT_EQ(data["p"], "AAAAAAEA/v+c/wAA");  // (0, 0), (1, -2), (-100, 0)
  EXPECT_EQ(pointsJson({})["p"], "");
  EXPECT_EQ(pointsJson({{0.0, 0.0}, {5000.0, 0.0}})["p"], "AAAAAP9/AAA=") << "what is too far away lies at the end";
}

}  // namespace
}  // namespace slam::event_text_test
