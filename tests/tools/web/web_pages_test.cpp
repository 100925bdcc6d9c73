// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_pages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mapping/map_files.hpp"
#include "problems/answers.hpp"
#include "tools/files.hpp"
#include "tools/web/map_tiles.hpp"

namespace slam::web_pages_test {
namespace {

using httplib::Request;
using httplib::Response;
using testing::HasSubstr;

class Pages : public testing::Test {
 protected:
  Pages() {
    std::filesystem::create_directories(files_ / "logs/run");
    files_.write("logs/run/0001.lcm", "records");
    files_.write("logs/run/a'b.lcm", "odd name");
    settings_.web.commands = true;
    settings_.web.token = "correct horse battery";
    settings_.logs = files_ / "logs";
    settings_.version = "1.2.3";
    map_meta_t meta{};
    meta.map_id = 4;
    meta.resolution = 0.1;
    meta.keyframes = 7;
    shared_.state.take(meta, {});
    shared_.state.take(MapLayer::kBoth, test::noisyTile(4, 0, 0, 1), {});
  }
  Response get(const std::string& path, const httplib::Params& params = {}, const std::string& method = "GET") {
    Request request;
    request.method = method;
    request.path = path;
    request.params = params;
    request.headers = headers_;
    request.remote_addr = address_;
    Response response;
    pages().answer(request, response);
    return response;
  }
  Response post(const std::string& body) {
    Request request;
    request.method = "POST";
    request.path = WebPages::kCommand;
    request.headers = headers_;
    request.remote_addr = address_;
    request.body = body;
    Response response;
    pages().command(request, response);
    return response;
  }
  Response drive(const std::string& body) {
    Request request;
    request.headers = headers_;
    request.body = body;
    Response response;
    pages().drive(request, response);
    return response;
  }
  WebPages& pages() {
    if (!pages_) {
      pages_.emplace(
          settings_, shared_, [this](const WebCommand& command) { return obey(command); },
          [this](const DriveRequest& request) { return follow(request); });
    }
    return *pages_;
  }
  std::optional<Acknowledged> obey(const WebCommand& command) {
    commands_.push_back(command);
    if (fails_) throw std::runtime_error("no route");
    return ack_;
  }

  Problem follow(const DriveRequest& request) {
    drives_.push_back(request);
    if (fails_) throw std::runtime_error("no route");
    return refusal_;
  }

  test::Folder files_;
  WebPages::Settings settings_;
  SharedState shared_{Config{}};
  httplib::Headers headers_;
  std::string address_;  // whom requests come from
  std::vector<WebCommand> commands_;
  std::vector<DriveRequest> drives_;
  Problem refusal_;
  std::optional<Acknowledged> ack_;
  bool fails_ = false;
  std::optional<WebPages> pages_;
};

TEST_F(Pages, AreOneDocumentWithItsScriptAndStyle) {
  const Response page = get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_THAT(page.body, HasSubstr("/page.js"));
  EXPECT_EQ(get("/page.js").get_header_value("Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(get("/page.css").get_header_value("Content-Type"), "text/css; charset=utf-8");
  EXPECT_EQ(get("/manifest.webmanifest").get_header_value("Content-Type"), "application/manifest+json; charset=utf-8");
  EXPECT_EQ(get("/icon.svg").status, 200);
  for (const char* path : {"/", "/page.js", "/page.css", "/manifest.webmanifest"}) {
    EXPECT_THAT(get(path).body, testing::Not(HasSubstr("http:"))) << path << " asks for an address outside the robot";
    EXPECT_THAT(get(path).body, testing::Not(HasSubstr("https:"))) << path;
  }
}

TEST_F(Pages, HaveMetricsForPrometheus) {
  const Response metrics = get("/metrics");
  EXPECT_EQ(metrics.status, 200);
  EXPECT_EQ(metrics.get_header_value("Content-Type"), "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_THAT(metrics.body, HasSubstr("slamd_silence_seconds"));
}

TEST_F(Pages, AllowNoScriptButTheirOwn) {
  const auto headers = WebPages::headers();
  const std::string policy = headers.find("Content-Security-Policy")->second;
  EXPECT_THAT(policy, HasSubstr("default-src 'none'"));
  EXPECT_THAT(policy, HasSubstr("script-src 'self'"));
  EXPECT_THAT(policy, testing::Not(HasSubstr("unsafe")));
  EXPECT_EQ(headers.find("X-Content-Type-Options")->second, "nosniff");
}

TEST_F(Pages, HaveAStatusOfJson) {
  const auto status = nlohmann::json::parse(get("/api/status").body);
  EXPECT_EQ(status["version"], "1.2.3");
  EXPECT_EQ(status["map"]["id"], 4);
  EXPECT_EQ(status["map"]["keyframes"], 7);
  EXPECT_TRUE(status["pose"].is_null());
}

TEST_F(Pages, HaveTheTilesThatChanged) {
  const Response all = get("/api/map");
  EXPECT_EQ(all.get_header_value("Content-Encoding"), "gzip");
  EXPECT_EQ(test::tilesIn(all.body).size(), 1U);
  shared_.state.take(MapLayer::kDepth, test::noisyTile(4, 0, 0, 2), {});
  EXPECT_EQ(test::tilesIn(get("/api/map").body).size(), 1U);
  EXPECT_EQ(test::tilesIn(get("/api/map", {{"layers", "1"}}).body).size(), 2U);
  const std::string version = std::to_string(shared_.state.tiles().version());
  EXPECT_EQ(test::tilesIn(get("/api/map", {{"since", version}}).body).size(), 0U);
  for (const char* wrong : {"", "-1", "x", "1e3", "99999999999999999999"})
    EXPECT_EQ(get("/api/map", {{"since", wrong}}).status, 400) << wrong;
}

TEST_F(Pages, HaveAMapThatNav2Loads) {
  const Response yaml = get("/map.yaml"), pgm = get("/map.pgm");
  files_.write("map.yaml", yaml.body);
  files_.write("map.pgm", pgm.body);
  const MapImage map = readMapFiles(files_ / "map.yaml");
  EXPECT_EQ(map.width, TileStore::kSide);
  EXPECT_EQ(map.resolution, 0.1);
  EXPECT_EQ(map.cells, shared_.state.tiles().image()->cells);
  EXPECT_EQ(get("/map.png").body.substr(1, 3), "PNG");
}

TEST_F(Pages, KeepThePairOfAMapTogether) {
  const std::string before = get("/map.pgm").body;
  shared_.state.take(MapLayer::kBoth, test::noisyTile(4, -3, 0, 2), {});
  EXPECT_THAT(get("/map.yaml").body, HasSubstr("origin: [0, 0, 0]")) << "of the picture that was loaded a moment ago";
}

TEST_F(Pages, RefuseAMapTooLargeForOnePicture) {
  shared_.state.take(MapLayer::kBoth, test::noisyTile(4, TileStore::kFarthest, 0, 2), {});
  EXPECT_EQ(get("/map.png").status, 409);
  EXPECT_EQ(get("/api/map").status, 200);
}

TEST_F(Pages, ListLogsAndGiveThem) {
  EXPECT_THAT(get("/logs/").body, HasSubstr("href=\"/logs/run/\""));
  EXPECT_THAT(get("/logs/run/").body, HasSubstr("href=\"/logs/run/0001.lcm\""));
  EXPECT_THAT(get("/logs/run/").body, testing::Not(HasSubstr("a'b"))) << "it could not be asked for";
  const Response file = get("/logs/run/0001.lcm");
  EXPECT_EQ(file.status, 200);
  EXPECT_EQ(file.content_length_, 7U);
  EXPECT_THAT(file.get_header_value("Content-Disposition"), HasSubstr("0001.lcm"));
  for (const char* path : {"/logs/../secret", "/logs/run/../../secret", "/logs/none", "/logs/run/none", "/logsx"})
    EXPECT_EQ(get(path).status, 404) << path;
  EXPECT_EQ(get("/logs").status, 301);
  const Response all = get("/api/v1/logs.zip");
  EXPECT_EQ(all.status, 200);
  EXPECT_THAT(all.get_header_value("Content-Disposition"), HasSubstr("logs.zip"));
}

TEST_F(Pages, ReportWhereNoLogsAre) {
  settings_.logs.clear();
  EXPECT_EQ(get("/logs/").status, 404);
  EXPECT_EQ(get("/api/v1/logs.zip").status, 404);
  EXPECT_THAT(get("/logs/").body, HasSubstr("log.directory"));
}

TEST_F(Pages, RefuseOtherPathsAndMethods) {
  EXPECT_EQ(get("/etc/passwd").status, 404);
  EXPECT_EQ(get("").status, 404);
  EXPECT_EQ(get("/", {}, "POST").status, 405);
  EXPECT_EQ(get("/api/map", {}, "DELETE").status, 405);
  EXPECT_EQ(get(WebPages::kCommand, {}, "GET").status, 404);
}

TEST_F(Pages, ObeyWhoHasTheToken) {
  ack_.emplace();
  ack_->accepted = true;
  ack_->message = "pose set";
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "application/json"}};
  const Response response = post(R"({"verb":"set_pose","x":1,"y":2,"theta":0.5})");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(nlohmann::json::parse(response.body)["message"], "pose set");
  ASSERT_EQ(commands_.size(), 1U);
  EXPECT_EQ(commands_[0].verb, "set_pose");
  EXPECT_THAT(commands_[0].pose, testing::ElementsAre(1.0, 2.0, 0.5));
  ack_->accepted = false;
  EXPECT_EQ(post(R"({"verb":"save"})").status, 409);
  EXPECT_EQ(get("/api/allowed").status, 200);
}

TEST_F(Pages, ObeyNobodyElse) {
  const std::string save = R"({"verb":"save"})";
  headers_ = {{"Content-Type", "application/json"}};
  EXPECT_EQ(post(save).status, 401);
  for (const char* token :
       {"Bearer ", "Bearer correct horse", "correct horse battery", "Basic correct horse battery"}) {
    headers_ = {{"Content-Type", "application/json"}, {"Authorization", token}};
    address_ = token;  // who guesses often from one is slowed down
    EXPECT_EQ(post(save).status, 401) << token;
    EXPECT_EQ(get("/api/allowed").status, 401) << token;
  }
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "text/plain"}};
  EXPECT_EQ(post(save).status, 415) << "what a form of another page can send";
  EXPECT_TRUE(commands_.empty());
}

TEST_F(Pages, ObeyOthersWhileOneAddressGuesses) {
  headers_ = {{"Content-Type", "application/json"}, {"Authorization", "Bearer a guess"}};
  address_ = "192.168.1.7";
  for (int i = 0; i < 6; ++i) EXPECT_EQ(get("/api/allowed").status, 401) << i;
  EXPECT_EQ(get("/api/allowed").status, 429);
  headers_ = {{"Content-Type", "application/json"}, {"Authorization", "Bearer correct horse battery"}};
  EXPECT_EQ(get("/api/allowed").status, 429) << "it is not looked at";
  address_ = "192.168.1.8";
  EXPECT_EQ(get("/api/allowed").status, 200);
}

TEST_F(Pages, ObeyNobodyWhereCommandsAreOff) {
  settings_.web.commands = false;
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "application/json"}};
  const Response response = post(R"({"verb":"save"})");
  EXPECT_EQ(response.status, 403);
  EXPECT_THAT(response.body, HasSubstr("web.commands"));
  EXPECT_TRUE(commands_.empty());
}

TEST_F(Pages, DriveWhereBothSettingsAllowIt) {
  const std::string ahead = R"({"vx":0.3,"omega":-0.1,"hold":7})";
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "application/json"}};
  EXPECT_EQ(drive(ahead).status, 403);
  EXPECT_THAT(drive(ahead).body, HasSubstr("base.speed_commands"));
  pages_.reset();
  settings_.drives = true;
  EXPECT_EQ(drive(ahead).status, 200);
  ASSERT_EQ(drives_.size(), 1U);
  EXPECT_EQ(drives_[0].twist.omega, -0.1);
  EXPECT_EQ(drives_[0].hold, 7U);
  pages_.reset();
  settings_.web.commands = false;
  EXPECT_EQ(drive(ahead).status, 403);
  EXPECT_EQ(drives_.size(), 1U);
}

TEST_F(Pages, DriveForNobodyElse) {
  settings_.drives = true;
  const std::string ahead = R"({"vx":0.3,"omega":0,"hold":7})";
  EXPECT_EQ(drive(ahead).status, 401);
  headers_ = {{"Authorization", "Bearer a guess"}, {"Content-Type", "application/json"}};
  EXPECT_EQ(drive(ahead).status, 401);
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "text/plain"}};
  EXPECT_EQ(drive(ahead).status, 415) << "what a form of another page can send";
  EXPECT_TRUE(drives_.empty());
}

TEST_F(Pages, ReportWhyASpeedIsNotDriven) {
  settings_.drives = true;
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "application/json"}};
  EXPECT_EQ(drive(R"({"vx":1e300,"omega":0,"hold":7})").status, 400);
  EXPECT_EQ(drive("{").status, 400);
  EXPECT_TRUE(drives_.empty());
  refusal_ = answer::kOtherDrives;
  const Response busy = drive(R"({"vx":0.3,"omega":0,"hold":7})");
  EXPECT_EQ(busy.status, 409);
  EXPECT_EQ(nlohmann::json::parse(busy.body)["message"], refusal_.words());
  EXPECT_EQ(nlohmann::json::parse(busy.body)["parts"][0]["id"], "other_drives");
  fails_ = true;
  EXPECT_EQ(drive(R"({"vx":0,"omega":0})").status, 502);
}

TEST_F(Pages, ReportWhatWasWrongWithACommand) {
  headers_ = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "application/json"}};
  EXPECT_EQ(post("{").status, 400);
  EXPECT_EQ(post(R"({"verb":"format_disk"})").status, 400);
  EXPECT_EQ(post(R"({"verb":"save"})").status, 504) << "no answer";
  fails_ = true;
  const Response response = post(R"({"verb":"save"})");
  EXPECT_EQ(response.status, 502);
  EXPECT_EQ(response.body, "no route\n");
}

}  // namespace
}  // namespace slam::web_pages_test
