// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/web/setup_server.hpp"

#include <future>
#include <gtest/gtest.h>
#include <sstream>

#include "support/wait_until.hpp"

namespace slam::setup_server_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

class Served : public testing::Test {
 protected:
  static WebConfig web() {
    WebConfig web;
    web.port = 0;
    web.commands = true;
    web.token = kToken;
    return web;
  }
  httplib::Headers with(const std::string& token) const { return {{"Authorization", "Bearer " + token}}; }
  int get(const std::string& path, const httplib::Headers& headers) {
    const auto answer = client_.Get(path, headers);
    return answer ? answer->status : 0;
  }
  int post(const std::string& path, const std::string& body, const std::string& token = kToken,
           const char* type = "application/json") {
    const auto answer = client_.Post(path, with(token), body, type);
    return answer ? answer->status : 0;
  }
  static constexpr const char* kToken = "correct-horse-battery";
  std::ostringstream terminal_;
  WebConsole console_{terminal_};
  SetupServer server_{web(), console_};
  httplib::Client client_{"127.0.0.1", server_.port()};
};

TEST_F(Served, GivesThePageToAnybodyAndTheRestToWhoHasTheToken) {
  EXPECT_EQ(get("/", {}), 200);
  EXPECT_EQ(get("/setup.js", {}), 200);
  EXPECT_EQ(get("/api/v1/setup", {}), 401);
  EXPECT_EQ(get("/api/v1/other", {}), 401);
  EXPECT_EQ(get("/api/v1/setup", with(kToken)), 200);
  EXPECT_EQ(get("/api/v1/other", with(kToken)), 404);
  EXPECT_EQ(get("/", {{"Host", "stranger.example"}}), 421) << "led here by a trick";
  EXPECT_EQ(client_.Delete("/api/v1/setup", with(kToken))->status, 404);
}

TEST_F(Served, SlowsDownWhoGuessesTheToken) {
  int last = 0;
  for (int guess = 0; guess < 8; ++guess) last = get("/api/v1/setup", with("guess" + std::to_string(guess)));
  EXPECT_EQ(last, 429);
  EXPECT_EQ(post("/api/v1/setup/answer", R"({"number": 1, "answer": "y"})", "guess"), 429);
}

TEST_F(Served, TakesAnAnswerOnceAndNothingElse) {
  auto answer = std::async(std::launch::async, [this] {
    return console_.answerTo({.id = "lidar.x", .text = "How far ahead?", .otherwise = "0.0"});
  });
  ASSERT_TRUE(test::waitUntil([this] { return !json::parse(console_.state())["question"].is_null(); }, 10s));
  for (const char* bad :
       {"", "[]", "{}", R"({"number": 1})", R"({"number": "1", "answer": "y"})", R"({"number": -1, "answer": "y"})",
        R"({"number": 1, "answer": 2})", R"({"number": 1, "answer": "0.1\nweb.commands = true"})"})
    EXPECT_EQ(post("/api/v1/setup/answer", bad), 400) << bad;
  EXPECT_EQ(post("/api/v1/setup/answer", json({{"number", 1}, {"answer", std::string(401, '1')}}).dump()), 400);
  EXPECT_EQ(post("/api/v1/setup/answer", R"({"number": 1, "answer": "0.1"})", kToken, "text/plain"), 415) << "a form";
  EXPECT_EQ(post("/api/v1/setup/answer", R"({"number": 1, "answer": "0.1"})", "guess"), 401);
  EXPECT_EQ(post("/api/v1/setup/answer", R"({"number": 1, "answer": "0.1"})"), 200);
  EXPECT_EQ(post("/api/v1/setup/answer", R"({"number": 1, "answer": "0.2"})"), 409);
  EXPECT_EQ(answer.get(), "0.1");
}

TEST_F(Served, DrivesByTheRulesOfSlamWeb) {
  EXPECT_EQ(post("/api/v1/drive", R"({"vx": 0.2, "omega": 0, "hold": 1})", "guess"), 401);
  EXPECT_EQ(post("/api/v1/drive", R"({"vx": 99, "omega": 0, "hold": 1})"), 400);
  EXPECT_EQ(post("/api/v1/drive", R"({"vx": 0.2, "omega": 0})"), 400) << "of no press";
  EXPECT_EQ(post("/api/v1/drive", R"({"vx": 0.2, "omega": 0, "hold": 1})"), 409) << "nothing is recorded";
}

}  // namespace
}  // namespace slam::setup_server_test
