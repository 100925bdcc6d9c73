// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_pages.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bus/problem_message.hpp"
#include "mapping/colour_image.hpp"
#include "mapping/map_files.hpp"
#include "problems/answer.hpp"
#include "problems/answers.hpp"
#include "runtime/clock.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/slamctl/log.hpp"
#include "tools/slamctl/map_list.hpp"
#include "tools/web/foxglove/upgrade.hpp"
#include "tools/web/logs/log_archive.hpp"
#include "tools/web/page_files.hpp"
#include "tools/web/text/event_text.hpp"
#include "tools/web/text/log_page.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using httplib::Request;
using httplib::Response;
constexpr Duration kPictureAge = 10s;
constexpr const char *kJson = "application/json", *kAllowed = "/api/v1/allowed";

void answerWith(Response& response, const std::string& content, const char* type) {
  response.status = 200;
  response.set_content(content, type);
}

void download(Response& response, const std::string& name) {
  response.set_header("Content-Disposition", "attachment; filename=\"" + name + "\"");
}

}  // namespace

WebPages::WebPages(Settings settings, const SharedState& shared, Commander commander, Driver driver)
    : settings_(std::move(settings)),
      shared_(shared),
      hosts_(settings_.web.address),
      gate_(settings_.web),
      commander_(std::move(commander)),
      driver_(std::move(driver)),
      maps_(settings_.maps, mapsJson),
      logs_(settings_.logs, logsJson),
      pictures_(settings_.maps, settings_.grid) {}

httplib::Headers WebPages::headers() {
  return {{"Content-Security-Policy",
           "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
           "manifest-src 'self'; worker-src 'self'; "
           "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
          {"X-Content-Type-Options", "nosniff"},
          {"X-Frame-Options", "DENY"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cache-Control", "no-store"}};
}

bool WebPages::mayStream(const Request& request, Response& response) const {
  Request asked = request;
  if (asked.has_param("token") && !asked.has_header("Authorization"))
    asked.headers.emplace("Authorization", "Bearer " + asked.get_param_value("token"));
  return gate_.mayRead(asked, response, monotonicNow()) &&
         upgrade(request, response, [this](const std::string& host) { return hosts_.isOwnHost(host); });
}

bool WebPages::mayRead(const Request& request, Response& response) const {
  const bool itself = findPageFile(request.path) != nullptr || apiPathOf(request.path) == kAllowed;
  return itself || gate_.mayRead(request, response, monotonicNow());
}

void WebPages::answer(const Request& request, Response& response) const {
  const std::string& path = request.path;
  const std::string api = apiPathOf(path);
  if (request.method != "GET" && request.method != "HEAD") {
    response.set_header("Allow", api == kCommand || api == kDrive ? "POST" : "GET, HEAD");
    return refuse(response, 405, "this method is not for this path");
  }
  if (!mayRead(request, response)) return;
  if (const PageFile* page = findPageFile(path)) return answerWith(response, std::string(page->content), page->type);
  if (path == "/metrics") return metrics(response);
  if (api == "/api/v1/status") return status(response);
  if (api == "/api/v1/history") return history(response);
  if (api == "/api/v1/map") return tiles(request, response);
  if (api == "/api/v1/maps") return list(maps_, "stores no maps here; set store.directory", response);
  if (const auto name = MapPictures::nameIn(api)) return mapPicture(*name, response);
  if (api == "/api/v1/logs") return list(logs_, "keeps no logs here; set log.directory", response);
  if (api == "/api/v1/logs.zip") return logArchive(response);
  if (api == kAllowed) {
    if (gate_.unlock(request, response, monotonicNow())) answerWith(response, "{\"allowed\":true}", kJson);
    return;
  }
  const std::string file = api.substr(api.starts_with(kApi) ? kApi.size() - 1 : 0);
  if (file == "/map.png" || file == "/map.pgm" || file == "/map.yaml") return mapFile(file, response);
  if (path.starts_with("/logs")) return logs(path, response);
  refuse(response, 404, "there is no such page; / has the map");
}

std::string WebPages::apiPathOf(const std::string& path) {
  constexpr std::string_view kFirst = "/api/";  // before there were versions
  return path.starts_with(kFirst) && !path.starts_with(kApi) ? std::string(kApi) + path.substr(kFirst.size()) : path;
}

void WebPages::list(const StoredList& stored, const char* otherwise, Response& response) const {
  if (!stored.isThere()) return refuse(response, 404, std::string("slamd ") + otherwise);
  try {
    answerWith(response, stored.text(monotonicNow()), kJson);
  } catch (const std::runtime_error& error) {
    refuse(response, 404, error.what());
  }
}

void WebPages::status(Response& response) const {
  using nlohmann::json;
  json body = {{"api", 1},
               {"version", settings_.version},
               {"commands", settings_.web.commands},
               {"drives", settings_.web.commands && settings_.drives},
               {"logs", !settings_.logs.empty()}};
  const Timestamp now = monotonicNow();
  {
    const std::lock_guard lock(shared_.mutex);
    const WebState& state = shared_.state;
    body["silence_s"] = toSeconds(state.silence(now));
    body["pose"] = state.pose() ? poseJson(*state.pose()) : json();
    body["health"] = state.health() ? healthJson(*state.health(), state.problems()) : json();
    body["map"] = mapJson(state);
    body["closures"] = state.closures().size();
    body["bad_messages"] = state.badMessages();
  }
  answerWith(response, textOf(body), kJson);
}

void WebPages::history(Response& response) const {
  std::optional<DayHistory> day;  // a copy: nobody waits for its text
  {
    const std::lock_guard lock(shared_.mutex);
    day = shared_.state.day();
  }
  answerWith(response, textOf(historyJson(*day)), kJson);
}

void WebPages::metrics(Response& response) const {
  std::string text;
  const Timestamp now = monotonicNow();
  {
    const std::lock_guard lock(shared_.mutex);
    text = metricsText(shared_.state, shared_.foxglove, settings_.version, now);
  }
  answerWith(response, text, "text/plain; version=0.0.4; charset=utf-8");
}

void WebPages::tiles(const Request& request, Response& response) const {
  const auto since =
      request.has_param("since") ? versionOf(request.get_param_value("since")) : std::optional(std::uint64_t{0});
  if (!since) return refuse(response, 400, "since is no version; leave it out for the whole map");
  // The layers are twice as much again, and few look at them.
  const auto wanted = request.has_param("layers") ? TileStore::Wanted::kAllLayers : TileStore::Wanted::kFused;
  std::string gzip;
  {
    const std::lock_guard lock(shared_.mutex);
    gzip = shared_.state.tiles().changedSince(*since, wanted);
  }
  response.set_header("Content-Encoding", "gzip");
  answerWith(response, gzip, "application/octet-stream");
}

std::shared_ptr<const WebPages::Picture> WebPages::picture() const {
  const std::lock_guard lock(drawing_);  // one is drawn at a time, however many ask
  const Timestamp now = monotonicNow();
  if (picture_ && now < drawn_ + kPictureAge) return picture_;
  std::optional<MapImage> map;
  {
    const std::lock_guard state(shared_.mutex);
    map = shared_.state.tiles().image();
  }
  picture_.reset();
  if (!map) return nullptr;
  std::string png = encodePng(colourMap(*map));
  picture_ = std::make_shared<const Picture>(Picture{*std::move(map), std::move(png)});
  drawn_ = now;
  return picture_;
}

void WebPages::mapPicture(const std::string& name, Response& response) const {
  try {
    answerWith(response, pictures_.png(name, monotonicNow()), "image/png");
  } catch (const std::runtime_error& error) {
    refuse(response, 404, error.what());
  }
}

void WebPages::mapFile(const std::string& path, Response& response) const {
  const auto picture = this->picture();
  if (!picture) return refuse(response, 409, "the map is too large for one picture here; use slamctl export");
  if (path == "/map.png") return answerWith(response, picture->png, "image/png");
  download(response, path.substr(1));
  if (path == "/map.pgm") return answerWith(response, encodePgm(picture->map), "image/x-portable-graymap");
  answerWith(response, encodeYaml("map.pgm", picture->map), "application/yaml");
}

void WebPages::logs(const std::string& path, Response& response) const {
  if (settings_.logs.empty()) return refuse(response, 404, "slamd keeps no logs here; set log.directory");
  if (path == "/logs") return response.set_redirect("/logs/", 301);
  const auto parts = logPathOf(path);
  const LogFolder folder(settings_.logs);
  const auto entries = parts ? folder.list(*parts) : std::nullopt;
  if (entries) return answerWith(response, logPage(*parts, *entries), "text/html; charset=utf-8");
  const auto file = parts ? folder.open(*parts) : nullptr;
  if (!file) return refuse(response, 404, "there is no such log");
  download(response, parts->back());
  response.status = 200;
  response.set_content_provider(file->size(), "application/octet-stream",
                                [file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                  std::vector<char> part(std::min<std::size_t>(length, 64 * 1024));
                                  const std::size_t got = file->read(offset, part.data(), part.size());
                                  return got > 0 && sink.write(part.data(), got);
                                });
}

void WebPages::logArchive(Response& response) const {
  if (settings_.logs.empty()) return refuse(response, 404, "slamd keeps no logs here; set log.directory");
  const auto archive = std::make_shared<LogArchive>(LogFolder(settings_.logs));
  download(response, "logs.zip");
  response.status = 200;
  response.set_chunked_content_provider("application/zip", [archive](std::size_t, httplib::DataSink& sink) {
    try {
      if (!archive->next([&](std::string_view bytes) { return sink.write(bytes.data(), bytes.size()); })) sink.done();
      return true;
    } catch (const std::runtime_error&) {
      return false;  // who asked is gone
    }
  });
}

bool WebPages::mayChange(const Request& request, Response& response) const {
  if (!gate_.mayCommand(request, response, monotonicNow())) return false;
  return isJson(request, response);
}

void WebPages::drive(const Request& request, Response& response) const {
  if (!settings_.drives) return refuse(response, 403, answerOf({answer::kSpeedsOff}));
  if (!mayChange(request, response)) return;
  answerDrive(request, response, driver_);
}

void WebPages::command(const Request& request, Response& response) const {
  if (!mayChange(request, response)) return;
  Answer problem;
  const auto command = commandOf(request.body, problem);
  if (!command) return refuse(response, 400, problem);
  const std::unique_lock one(commanding_, std::try_to_lock);
  if (!one) return refuse(response, 409, answerOf({answer::kWebBusy}));
  try {
    const auto ack = commander_(*command);
    if (!ack) return refuse(response, 504, answerOf({answer::kWebSilent}));
    answerWith(response, ack->accepted != 0, ack->message, ack->parts);
    maps_.forget(), logs_.forget(), pictures_.forget();
  } catch (const std::runtime_error& error) {
    refuse(response, 502, error.what());
  }
}

}  // namespace slam
