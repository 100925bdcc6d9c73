// SPDX-License-Identifier: BSD-3-Clause
// docs/api.md against the answers: each field of an answer has a row there with its type, and each row is answered.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "bus/problem_message.hpp"
#include "problems/devices.hpp"
#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"
#include "tools/slamctl/doctor.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/web/map_tiles.hpp"
#include "tools/web/text/event_text.hpp"
#include "tools/web/web_pages.hpp"

namespace slam::api_document_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

/// Cells of a row of a table, without blanks around them.
std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream row(line.substr(1));
  for (std::string cell; std::getline(row, cell, '|');) {
    const auto begin = cell.find_first_not_of(' ');
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, cell.find_last_not_of(' ') + 1 - begin));
  }
  return cells;
}

/// What stands in backticks.
std::vector<std::string> namesIn(const std::string& cell) {
  static const std::regex kName("`([^`]+)`");
  std::vector<std::string> names;
  for (std::sregex_iterator at(cell.begin(), cell.end(), kName), end; at != end; ++at) names.push_back((*at)[1]);
  return names;
}

/// The tables of docs/api.md.
struct Document {
  Document() {
    std::istringstream text(test::contentOf(std::filesystem::path(SLAMD_SOURCE_DIR) / "docs/api.md"));
    std::string object;
    bool events = false;
    for (std::string line; std::getline(text, line);) {
      if (line.starts_with("#")) {
        object = line.starts_with("### ") ? namesIn(line).at(0) : "";
        events = line == "## Events";
        if (!object.empty()) types[object];
      }
      if (!line.starts_with("| `")) continue;
      const auto cells = cellsOf(line);
      for (const std::string& name : namesIn(cells.at(0))) {
        if (!object.empty()) types[object][name] = cells.at(1);
        if (object.empty()) (events ? event_types : answers)[name] = cells.at(1);
      }
    }
  }

  std::map<std::string, std::map<std::string, std::string>> types;  // of the fields of each object
  std::map<std::string, std::string> answers, event_types;          // by path or command; by event
};

/// Compares JSON with the document.
class Comparison {
 public:
  explicit Comparison(const Document& document) : document_(document) {}

  void check(const json& value, const std::string& type, const std::string& where) {
    if (type.ends_with(" or null")) {
      (value.is_null() ? nulls_ : values_).insert(type + " " + where);
      return value.is_null() ? void() : check(value, type.substr(0, type.size() - 8), where);
    }
    if (type.starts_with("list of ")) {
      EXPECT_TRUE(value.is_array()) << where << ": " << value;
      for (const json& element : value) check(element, type.substr(8), where + "[]");
    } else if (type.starts_with("object of ")) {
      EXPECT_TRUE(value.is_object()) << where << ": " << value;
      for (const json& element : value) check(element, type.substr(10), where + ".*");
    } else if (type.starts_with("`")) {
      checkObject(value, namesIn(type).at(0), where);
    } else {
      const bool right = type == "string"    ? value.is_string()
                         : type == "integer" ? value.is_number_integer()
                         : type == "number"  ? value.is_number()
                                             : type == "boolean" && value.is_boolean();
      EXPECT_TRUE(right) << where << " is no " << type << ": " << value;
    }
  }
  /// Objects of the document that no answer had.
  std::set<std::string> missing() const {
    std::set<std::string> names;
    for (const auto& [name, fields] : document_.types)
      if (!seen_.contains(name)) names.insert(name);
    return names;
  }

 private:
  void checkObject(const json& value, const std::string& name, const std::string& where) {
    ASSERT_TRUE(document_.types.contains(name)) << "docs/api.md has no object " << name;
    ASSERT_TRUE(value.is_object()) << where << ": " << value;
    seen_.insert(name);
    const auto& fields = document_.types.at(name);
    for (const auto& [key, field] : value.items()) {
      const auto row = fields.find(key);
      if (row == fields.end()) {
        ADD_FAILURE() << "docs/api.md has no row for " << key << " of " << name << " (" << where << ")";
      } else {
        check(field, row->second, where + "." + key);
      }
    }
    for (const auto& [key, type] : fields)
      EXPECT_TRUE(value.contains(key)) << where << " has no field " << key << ", which docs/api.md has of " << name;
  }

  const Document& document_;
  std::set<std::string> seen_, nulls_, values_;
};

health_t fullHealth() {
  health_t health{};
  health.summary = "pose localised";
  health.devices.resize(health.ndevices = 1);
  health.devices[0].name = "lidar";
  health.stages.resize(health.nstages = 1);
  health.counters.resize(health.ncounters = 1);
  health.counters[0].name = "loop_closures";
  return health;
}

pose_estimate_t somePose(std::int64_t utime) {
  pose_estimate_t pose{};
  pose.utime = utime;
  pose.map_id = 4;
  pose.state = 1;
  return pose;
}

class ApiDocument : public testing::Test {
 protected:
  ApiDocument() {
    std::filesystem::create_directories(files_ / "logs/run");
    files_.write("logs/run/0001.lcm", "");
    files_.write("logs/run/0001.mark", "hit the wall\n");
    MapStore(files_ / "maps", "home").checkpoint(test::ChangingMap(4).map);
    settings_.maps = files_ / "maps";
    settings_.logs = files_ / "logs";
    settings_.web.commands = true;
    settings_.web.token = "correct horse battery";
  }
  /// All that a robot sends.
  void fill(WebState& state, Timestamp now) {
    health_t health = fullHealth();
    state.take(health, now);
    state.take(somePose(1'700'000'000'000'000), now);
    health.counters[0].value = 1;  // a closure
    problems_t problems{};
    problems.problems = {toMessage("lidar", Problem(problem::kSilent), true)};
    state.take(problems, now);
    state.take(health, now);
    state.take(MapLayer::kBoth, test::noisyTile(4, 0, 0, 1), now);
    map_edit_t edit{};
    edit.map_id = 4;
    edit.edits = 1;
    edit.kind = "zone";
    edit.npoints = 3;
    edit.x = {0.0, 1.0, 1.0}, edit.y = {0.0, 0.0, 1.0};
    state.take(edit, now);
    scan_t scan{};
    scan.utime = 1'700'000'000'000'000;
    scan.nbeams = 1;
    scan.range_max = 10.0F;
    scan.ranges = {2.0F};
    scan.bearings = scan.time_offsets = scan.intensities = {0.0F};
    state.take(scan, now);
    depth_t depth{};
    depth.utime = scan.utime;
    state.take(depth, now);
  }
  std::string textAt(const std::string& path) {
    httplib::Request request;
    request.method = "GET";
    request.path = path;
    request.headers = {{"Authorization", "Bearer correct horse battery"}};
    httplib::Response response;
    pages_->answer(request, response);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body;
    return response.body;
  }
  json post(const std::string& body, void (WebPages::*answer)(const httplib::Request&, httplib::Response&) const) {
    httplib::Request request;
    request.headers = {{"Authorization", "Bearer correct horse battery"}, {"Content-Type", "application/json"}};
    request.body = body;
    httplib::Response response;
    (*pages_.*answer)(request, response);
    return json::parse(response.body, nullptr, false);
  }

  test::Folder files_;
  WebPages::Settings settings_;
  SharedState shared_{Config{}};
  std::optional<WebPages> pages_;
  const Document document_;
  Comparison comparison_{document_};
};

TEST_F(ApiDocument, HasEachFieldOfTheAnswersAndNoOther) {
  settings_.drives = true;
  pages_.emplace(
      settings_, shared_, [](const WebCommand&) { return std::optional(Acknowledged(ack_t{}, {problem_t{}})); },
      [](const DriveRequest&) { return Problem(); });
  std::set<std::string> paths;
  for (int filled = 0; filled < 2; ++filled) {  // before the robot sends anything, and behind it
    for (const auto& [path, type] : document_.answers) {
      if (!path.starts_with("GET ") || path.ends_with("/events")) continue;
      const json answer = json::parse(textAt(path.substr(4)), nullptr, false);
      if (type.starts_with("`") || type.starts_with("list of `"))
        comparison_.check(answer, type.substr(0, type.find_first_of(",;")), path);
      paths.insert(path);
    }
    fill(shared_.state, Timestamp(100s));
  }
  EXPECT_GE(paths.size(), 9U);
  comparison_.check(post(R"({"verb": "save"})", &WebPages::command),
                    document_.answers.at("POST /api/v1/command").substr(0, 5), "command");
  comparison_.check(post(R"({"vx": 0.2, "omega": 0.0, "hold": 1})", &WebPages::drive),
                    document_.answers.at("POST /api/v1/drive").substr(0, 5), "drive");
  comparison_.check(findingsJson({{Finding::kGood, "clock: set", ""}}), document_.answers.at("doctor"), "doctor");

  WebState state{Config{}};
  EventFeed feed(1, true, "1.2.3");
  std::string stream = feed.greeting(state, Timestamp(100s)) + feed.news(state, Timestamp(100s));
  fill(state, Timestamp(100s));
  stream += feed.news(state, Timestamp(102s)) + feed.greeting(state, Timestamp(102s));
  std::set<std::string> events;
  std::istringstream lines(stream);
  for (std::string line, event; std::getline(lines, line);) {
    if (line.starts_with("event: ")) events.insert(event = line.substr(7));
    if (!line.starts_with("data: ")) continue;
    ASSERT_TRUE(document_.event_types.contains(event)) << "docs/api.md has no event " << event;
    comparison_.check(json::parse(line.substr(6)), document_.event_types.at(event), event);
  }
  for (const auto& [event, type] : document_.event_types) EXPECT_TRUE(events.contains(event)) << event;
  EXPECT_THAT(comparison_.missing(), testing::IsEmpty());
}

TEST_F(ApiDocument, HasPathsThatAreTheSameWithoutTheirVersion) {
  pages_.emplace(settings_, shared_,
                 [](const WebCommand&) { return std::optional(Acknowledged(ack_t{}, {problem_t{}})); });
  for (const auto& [path, type] : document_.answers) {
    const auto at = path.find("/api/v1/");
    if (!path.starts_with("GET ") || at == std::string::npos) continue;
    const std::string first = "/api/" + path.substr(at + 8);
    EXPECT_EQ(WebPages::apiPathOf(first), path.substr(at));
    if (path.ends_with("/events")) continue;
    const auto withoutSilence = [](const std::string& text) { return text.substr(0, text.find("\"silence_s\"")); };
    EXPECT_EQ(withoutSilence(textAt(first)), withoutSilence(textAt(path.substr(at)))) << path;
  }
}

}  // namespace
}  // namespace slam::api_document_test
