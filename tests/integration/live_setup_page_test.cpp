// SPDX-License-Identifier: BSD-3-Clause
// slamctl setup --web from its address to a configuration, with an emulated robot that obeys, over HTTP as its page
// does.
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <slam/drive_t.hpp>

#include "config/loader.hpp"
#include "integration/live.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/web/http_library.hpp"

namespace slam::live_setup_page_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
namespace fs = std::filesystem;
using test::Clock;
using Seconds = std::chrono::duration<double>;

class LiveSetupPage : public test::Live {
 protected:
  void SetUp() override {
    test::Live::SetUp();
    startSimulator("600", "meeting-room", {"--obey"});
    std::ofstream(folder_ / "answers") << "runtime.socket = " << (folder_ / "socket").string() << "\n"
                                       << (test::kSanitized ? "runtime.realtime = false\n" : "");
    std::ofstream(file()) << "# mine\n[lidar]\nyaw = 0.06\n";
    setup_.emplace(std::vector<std::string>{test::kBin + "/slamctl", "--config", file(), "setup", "--web", "--web-port",
                                            "0", "--qr", "--answers", folder_ / "answers", "--drive", "30", "--port",
                                            folder_ / "devices/lidar", "--port", folder_ / "devices/board"},
                   folder_ / "setup.txt");
    std::smatch found;
    const std::regex address("http://[^ :]+:([0-9]+)/#token=([0-9a-f]{32})");
    std::string words;
    for (const auto end = Clock::now() + 20s; Clock::now() < end && !std::regex_search(words, found, address);)
      words = textOf(folder_ / "setup.txt"), usleep(20000);
    ASSERT_EQ(found.size(), 3U) << words;
    page_.emplace("127.0.0.1", std::stoi(found[1]));
    token_ = found[2];
  }
  fs::path file() const { return folder_ / "slamd.toml"; }
  httplib::Headers headers(const std::string& token) const { return {{"Authorization", "Bearer " + token}}; }
  json state() {
    const auto answer = page_->Get("/api/v1/setup", headers(token_));
    return answer && answer->status == 200 ? json::parse(answer->body) : json();
  }
  /// @return status of HTTP; 0: no answer
  int post(const char* path, const json& body, const std::string& token) {
    const auto answer = page_->Post(path, headers(token), body.dump(), "application/json");
    return answer ? answer->status : 0;
  }
  int reply(const json& number, const std::string& words) {
    return post("/api/v1/setup/answer", {{"number", number}, {"answer", words}}, token_);
  }
  /// The next question. @return null where none comes
  json question() {
    const auto end = Clock::now() + test::kPatience * 60s;
    json question;
    while (question.is_null() && Clock::now() < end) {
      const json now = state();
      if (now.is_object()) question = now["question"];
      usleep(50000);
    }
    return question;
  }
  /// Answers questions by their ids, all others by their defaults, until this one comes.
  json answerUntil(const std::string& id, const std::map<std::string, std::string>& answers) {
    for (;;) {
      json asked = question();
      if (asked.is_null() || asked["id"] == id) return asked;
      const auto at = answers.find(asked["id"]);
      EXPECT_EQ(reply(asked["number"], at == answers.end() ? "" : at->second), 200) << asked;
    }
  }
  int drive(double vx, double omega, int hold) {
    return post("/api/v1/drive", {{"vx", vx}, {"omega", omega}, {"hold", hold}}, token_);
  }
  /// Holds the stick.
  void hold(double vx, double omega, Seconds time, int press) {
    for (const auto end = Clock::now() + time; Clock::now() < end; usleep(60000)) drive(vx, omega, press);
    drive(0.0, 0.0, press);
  }
  /// Until the drive's progress is this.
  bool waitForDrive(bool over) {
    for (const auto end = Clock::now() + test::kPatience * 60s; Clock::now() < end; usleep(50000)) {
      const json now = state();
      const json progress = now.is_object() ? now.value("progress", json()) : json();
      if (progress.is_object() && progress["over"] == over) return true;
    }
    return false;
  }

  std::optional<test::Process> setup_;
  std::optional<httplib::Client> page_;
  std::string token_;
};

TEST_F(LiveSetupPage, IsForWhoHasItsTokenAndTakesEachAnswerOnce) {
  const auto page = page_->Get("/");
  ASSERT_TRUE(page);
  EXPECT_NE(page->body.find("/setup.js"), std::string::npos);
  EXPECT_NE(page->get_header_value("Content-Security-Policy"), "");
  EXPECT_EQ(page_->Get("/api/v1/setup")->status, 401);
  EXPECT_EQ(page_->Get("/api/v1/setup", headers("guess"))->status, 401);
  EXPECT_EQ(post("/api/v1/setup/answer", {{"number", 1}, {"answer", "y"}}, "guess"), 401);
  EXPECT_EQ(post("/api/v1/drive", {{"vx", 0.1}, {"omega", 0}, {"hold", 1}}, "guess"), 401);
  EXPECT_EQ(page_->Get("/api/v1/setup", {{"Host", "stranger.example"}, {"Authorization", "Bearer " + token_}})->status,
            421);
  EXPECT_NE(textOf(folder_ / "setup.txt").find("█"), std::string::npos) << "a QR code";

  json asked = answerUntil("lidar.x", {});
  ASSERT_TRUE(asked.is_object());
  EXPECT_EQ(question()["number"], asked["number"]) << "whoever loads the page sees the same question";
  EXPECT_EQ(reply(asked["number"], "0.1\nweb.commands = true"), 400) << "one line alone";
  EXPECT_EQ(reply(asked["number"], std::string(5000, 'x')), 413);
  EXPECT_EQ(reply("1", "0.1"), 400);
  EXPECT_EQ(reply(asked["number"], "far"), 200);
  const json again = question();
  EXPECT_EQ(again["id"], "lidar.x");
  EXPECT_NE(again["error"], "") << "with the reason";
  EXPECT_EQ(reply(asked["number"], "0.1"), 409) << "that was the question before";
  EXPECT_EQ(drive(0.2, 0.0, 5), 409) << "nothing is recorded";
  const json last = answerUntil("write", {{"lidar.x", "0.1"}, {"calibrate", "n"}});
  EXPECT_EQ(reply(last["number"], "n"), 200);
  ASSERT_EQ(question()["id"], "finish");
  EXPECT_FALSE(state()["outcome"]["written"]);
  EXPECT_EQ(textOf(file()), "# mine\n[lidar]\nyaw = 0.06\n") << "nothing was written";
  EXPECT_EQ(reply(question()["number"], "y"), 200);
  EXPECT_EQ(setup_->wait(20s).value_or(-1), 1);
}

TEST_F(LiveSetupPage, DrivesCalibratesWritesAndChecks) {
  if (test::kSanitized) GTEST_SKIP() << "skipped: with sanitizers the devices are not played in real time";
  const Pose2 mount = sim::LidarModel::kExtrinsics;
  test::Listener listener;
  const json asked =
      answerUntil("joystick", {{"lidar.x", std::to_string(mount.x)}, {"lidar.y", "0"}, {"calibrate", "y"}});
  ASSERT_TRUE(asked.is_object());
  EXPECT_EQ(state()["devices"].size(), 2U);
  EXPECT_EQ(drive(0.2, 0.0, 1), 409) << "before the answer";
  ASSERT_EQ(reply(asked["number"], "y"), 200);
  ASSERT_TRUE(waitForDrive(false));
  EXPECT_EQ(state()["joystick"]["max_speed"], 0.3);
  hold(0.3, 0.0, 2s, 11);
  // The page goes away while it drives: its last speed is followed by a zero.
  const auto isSent = [&](double vx) {
    const auto sent = listener.last<drive_t>("SLAM_DRIVE");
    return sent && sent->vx == vx && sent->omega == 0.0;
  };
  drive(0.25, 0.0, 12);
  const auto begin = Clock::now();
  ASSERT_TRUE(listener.until([&] { return isSent(0.25); }, 5s));
  ASSERT_TRUE(listener.until([&] { return isSent(0.0); }, 5s));
  const Seconds silent = Clock::now() - begin;
  std::printf("a lost page stops the wheels after %.0f ms\n", 1e3 * silent.count());
  EXPECT_LT(silent, 1s) << "250 ms, and what a busy machine takes";
  EXPECT_EQ(drive(0.25, 0.0, 12), 409) << "that press is over";
  int press = 20;
  for (int turn = 0; turn < 2; ++turn) {
    hold(0.0, 0.8, 4s, ++press);
    hold(0.25, 0.3, 2s, ++press);
    hold(0.0, -0.8, 4s, ++press);
    hold(-0.25, 0.3, 2s, ++press);
  }
  const json driven = state()["progress"];
  EXPECT_GT(driven["left"], 3.0) << driven;
  EXPECT_GT(driven["straight"], 0.3) << driven;
  ASSERT_TRUE(waitForDrive(true));
  const json write = answerUntil("write", {});
  ASSERT_TRUE(write.is_object());
  EXPECT_EQ(drive(0.25, 0.0, 99), 409) << "the drive is over";
  const json shown = state();
  ASSERT_TRUE(shown.contains("calibration")) << shown;
  std::printf("%s\n", shown["calibration"].dump().c_str());
  for (const char* picture : {"/api/v1/setup/scans.png", "/api/v1/setup/map.png"}) {
    EXPECT_EQ(page_->Get(picture)->status, 401) << picture;
    const auto png = page_->Get(picture, headers(token_));
    ASSERT_TRUE(png && png->status == 200) << picture;
    EXPECT_EQ(png->body.substr(1, 3), "PNG");
  }
  EXPECT_EQ(textOf(file()), "# mine\n[lidar]\nyaw = 0.06\n") << "nothing is written before a yes";
  EXPECT_FALSE(shown["changes"]["lines"].empty());
  ASSERT_EQ(reply(write["number"], "y"), 200);
  const json finish = question();
  ASSERT_EQ(finish["id"], "finish");
  const json outcome = state()["outcome"];
  EXPECT_TRUE(outcome["good"]) << state()["findings"];
  EXPECT_EQ(reply(finish["number"], "y"), 200);
  EXPECT_EQ(setup_->wait(20s).value_or(-1), 0);
  const Config config = loadConfig(file());
  const Pose2 error = between(mount, config.front_end.lidar.T_base_lidar);
  EXPECT_LT(std::abs(error.theta), 0.02);
  EXPECT_FALSE(config.base_device.speed_commands) << "the joystick was for this drive alone";
  EXPECT_NE(textOf(file()).find("# mine"), std::string::npos);
  EXPECT_EQ(textOf(file().string() + ".old"), "# mine\n[lidar]\nyaw = 0.06\n");
}

}  // namespace
}  // namespace slam::live_setup_page_test
