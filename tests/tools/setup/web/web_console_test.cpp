// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/web/web_console.hpp"

#include <future>
#include <gtest/gtest.h>
#include <sstream>

#include "problems/answers.hpp"
#include "support/wait_until.hpp"
#include "tools/slamctl/setup/drive_calibration.hpp"
#include "tools/slamctl/setup/drive_progress.hpp"
#include "tools/slamctl/setup/machine.hpp"

namespace slam::web_console_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using test::waitUntil;

class Web : public testing::Test {
 protected:
  json state() const { return json::parse(console_.state()); }
  std::future<std::string> ask(const Question& question) {
    auto answer = std::async(std::launch::async, [this, question] { return console_.answerTo(question); });
    EXPECT_TRUE(waitUntil([this] { return !state()["question"].is_null(); }, 10s));
    return answer;
  }
  std::ostringstream terminal_;
  WebConsole console_{terminal_};
};

TEST_F(Web, WaitsForOneAnswerToEachQuestion) {
  console_.out() << "Looking at 1 port\n";
  auto answer = ask({.id = "lidar.x", .text = "How far ahead?", .otherwise = "0.0", .error = "far is no number"});
  const json question = state()["question"];
  EXPECT_EQ(question["number"], 1);
  EXPECT_EQ(question["kind"], "text");
  EXPECT_EQ(question["default"], "0.0");
  EXPECT_EQ(question["error"], "far is no number");
  EXPECT_EQ(state()["log"], "Looking at 1 port\n");
  EXPECT_EQ(terminal_.str(), "Looking at 1 port\n");
  EXPECT_TRUE(console_.take(2, "0.2")) << "there is no such question yet";
  EXPECT_FALSE(console_.take(1, "0.1"));
  EXPECT_EQ(console_.take(1, "0.2").id(), std::string(answer::kSetupAnswered.id));
  EXPECT_EQ(answer.get(), "0.1");
  EXPECT_TRUE(state()["question"].is_null());
  EXPECT_EQ(state()["answered"], json({{{"id", "lidar.x"}, {"text", "How far ahead?"}, {"answer", "0.1"}}}));
  auto next = ask({.kind = Question::kChoice, .id = "lidar.port", .text = "2 devices", .choices = {"a", "b"}});
  EXPECT_EQ(state()["question"]["number"], 2);
  EXPECT_EQ(state()["question"]["choices"], json({"a", "b"}));
  EXPECT_TRUE(console_.take(1, "1"));
  EXPECT_FALSE(console_.take(2, "2"));
  EXPECT_EQ(next.get(), "2");
}

TEST_F(Web, ShowsWhatWasFoundAndWhatIsToBeWritten) {
  console_.show(Machine{
      .ports = {{.path = "/x/a1", .finding = {.kind = PortFinding::kLidar, .name = "an RPLidar", .baud = 115200}},
                {.path = "/x/b", .finding = {.problem = answer::kNoPlace, .is_open = false}}},
      .buses = {{"can0", {16, 24}}},
      .chips = {"mpu6050"},
      .camera = true});
  const json devices = state()["devices"];
  ASSERT_EQ(devices.size(), 5U);
  EXPECT_EQ(devices[0]["name"], "an RPLidar");
  EXPECT_TRUE(devices[0]["problem"].is_null());
  EXPECT_EQ(devices[1]["problem"]["id"], answer::kNoPlace.id);
  EXPECT_EQ(devices[2]["name"], "ODrive");
  console_.show(DriveProgress{.phase = DriveProgress::kOver});
  console_.enter(SetupStep::kDrive);
  EXPECT_TRUE(state()["progress"].is_null()) << "another drive";
  console_.showNoCalibration("too short");
  EXPECT_EQ(state()["no_calibration"], "too short");
  DriveCalibration calibration{.values = {{"lidar.x", "m", 0.1, 0.12, 0.001, true}}, .open = "", .used = 40};
  calibration.translation_before = 0.01;
  console_.show(calibration);
  EXPECT_TRUE(state()["no_calibration"].is_null()) << "the second drive was good";
  EXPECT_EQ(state()["calibration"]["values"][0]["estimated"], 0.12);
  EXPECT_EQ(state()["calibration"]["translation"], json({0.01, 0.0}));
  EXPECT_EQ(console_.picture("map"), "");
  console_.showPictures("", "PNG");
  EXPECT_EQ(console_.picture("map"), "PNG");
  EXPECT_TRUE(state()["pictures"]["map"]);
  EXPECT_FALSE(state()["pictures"]["scans"]);
  console_.show(PlannedChanges{"/x/slamd.toml", false, {"lidar.x = 0.12, was 0.1"}});
  EXPECT_EQ(state()["changes"]["lines"][0], "lidar.x = 0.12, was 0.1");
  console_.show(Findings{{Finding::kFault, "lidar: gone", "plug it in"}});
  EXPECT_EQ(state()["findings"][0]["level"], "fault");
}

TEST_F(Web, DrivesNothingOutsideOfARecordedDrive) {
  const DriveRequest ahead{.twist = {0.2, 0.0, 0.0}, .hold = 7};
  EXPECT_EQ(console_.drive(ahead).id(), std::string(answer::kSetupStands.id)) << "nobody has agreed";
  console_.show(DriveProgress{.phase = DriveProgress::kBegins, .length = 30.0});
  EXPECT_EQ(console_.drive(ahead).id(), std::string(answer::kSetupStands.id)) << "it is pushed";
  EXPECT_FALSE(state()["progress"]["over"]);
  Config config;
  config.base_device.limits = {.max_speed = 0.3, .max_turn_rate = 0.8};
  console_.show(DriveProgress{.phase = DriveProgress::kOver});
  console_.giveJoystick(config);
  EXPECT_EQ(state()["joystick"]["max_speed"], 0.3);
  EXPECT_EQ(console_.drive(ahead).id(), std::string(answer::kSetupStands.id)) << "scans and wheels have not come";
  console_.show(DriveProgress{.phase = DriveProgress::kOver});
  EXPECT_EQ(console_.drive(ahead).id(), std::string(answer::kSetupStands.id));
  EXPECT_TRUE(state()["joystick"].is_null());
}

TEST_F(Web, EndsWhenSomebodyHasSeenHow) {
  auto ended = std::async(std::launch::async, [this] { console_.fail("no port"); });
  ASSERT_TRUE(waitUntil([this] { return !state()["question"].is_null(); }, 10s));
  EXPECT_EQ(state()["failure"], "no port");
  EXPECT_EQ(state()["step"], "done");
  EXPECT_EQ(ended.wait_for(0s), std::future_status::timeout);
  EXPECT_FALSE(console_.take(1, "y"));
  ended.get();
}

}  // namespace
}  // namespace slam::web_console_test
