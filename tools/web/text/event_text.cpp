// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/text/event_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "tools/slamctl/health_json.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
constexpr Duration kScanPeriod = 180ms, kDepthPeriod = 280ms, kMapPeriod = 450ms, kBeatPeriod = 1s;

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (int k = 3; k >= 0; --k) {
      const bool beyond = i + static_cast<std::size_t>(3 - k) > bytes.size();
      text += beyond ? '=' : kDigits[group >> (6 * k) & 63];
    }
  }
  return text;
}

json closureJson(const WebState::Closure& closure) {
  return {{"x", rounded(closure.at.x())}, {"y", rounded(closure.at.y())}, {"n", closure.total}};
}

}  // namespace

json mapJson(const WebState& state) {
  const TileStore& tiles = state.tiles();
  return {{"id", tiles.mapId()},
          {"version", tiles.version()},
          {"resolution", tiles.resolution()},
          {"tiles", state.meta() ? state.meta()->tiles : 0},
          {"keyframes", state.meta() ? state.meta()->keyframes : 0}};
}

json pointsJson(const WebState::Points& points) {
  const Eigen::Vector2d first = points.empty() ? Eigen::Vector2d(0.0, 0.0) : points.front();
  const std::array<std::int64_t, 2> corner = {std::llround(100.0 * first.x()), std::llround(100.0 * first.y())};
  std::vector<std::uint8_t> bytes;
  bytes.reserve(4 * points.size());
  for (const Eigen::Vector2d& p : points) {
    for (int i = 0; i < 2; ++i) {
      const auto offset =
          std::clamp<std::int64_t>(std::llround(100.0 * p[i]) - corner[static_cast<std::size_t>(i)], -32768, 32767);
      bytes.push_back(static_cast<std::uint8_t>(offset));
      bytes.push_back(static_cast<std::uint8_t>(offset >> 8));
    }
  }
  return {{"x", corner[0]}, {"y", corner[1]}, {"p", base64(bytes)}};
}

json trailJson(const WebState& state) {
  json points = json::array();
  for (const Eigen::Vector2d& p : state.trail()) {
    points.push_back(std::llround(100.0 * p.x()));
    points.push_back(std::llround(100.0 * p.y()));
  }
  json closures = json::array();
  for (const WebState::Closure& closure : state.closures()) closures.push_back(closureJson(closure));
  return {{"cm", std::move(points)}, {"closures", std::move(closures)}};
}

std::string eventText(const char* name, const json& data) {
  return std::string("event: ") + name + "\ndata: " + textOf(data) + "\n\n";
}

std::string EventFeed::greeting(const WebState& state, Timestamp now) const {
  // A page tries again 1 s after it has lost the stream.
  std::string text = "retry: 1000\n\n";
  text += eventText("hello", {{"session", session_},
                              {"version", version_},
                              {"commands", commands_},
                              {"drives", commands_ && limits_},
                              {"max_speed", limits_ ? limits_->max_speed : 0.0},
                              {"max_turn_rate", limits_ ? limits_->max_turn_rate : 0.0},
                              {"since", state.sinceState()},
                              {"silence", rounded(toSeconds(state.silence(now)), 10)}});
  text += eventText("trail", trailJson(state));
  if (state.health()) text += eventText("health", healthJson(*state.health(), state.problems()));
  if (state.pose()) text += eventText("pose", poseJson(*state.pose()));
  return text + eventText("map", mapJson(state)) + eventText("edits", editsJson(state.edits()));
}

bool EventFeed::isDue(Timestamp& last, Duration period, Timestamp now) const {
  if (now < last + period) return false;
  last = now;
  return true;
}

std::string EventFeed::news(const WebState& state, Timestamp now) {
  const WebState::Serials& serials = state.serials();
  std::string text;
  if (serials.pose != sent_.pose) text += eventText("pose", poseJson(*state.pose()));
  if (serials.health != sent_.health) text += eventText("health", healthJson(*state.health(), state.problems()));
  if (serials.closure != sent_.closure && !state.closures().empty())
    text += eventText("closure", closureJson(state.closures().back()));
  WebState::Serials sent = serials;
  sent.scan = sent_.scan, sent.depth = sent_.depth;
  if (serials.scan != sent_.scan && isDue(scan_, kScanPeriod, now)) {
    text += eventText("scan", pointsJson(state.scan()));
    sent.scan = serials.scan;
  }
  if (serials.depth != sent_.depth && isDue(depth_, kDepthPeriod, now)) {
    text += eventText("depth", pointsJson(state.depth()));
    sent.depth = serials.depth;
  }
  if (state.tiles().version() != map_version_ && isDue(map_, kMapPeriod, now)) {
    text += eventText("map", mapJson(state));
    map_version_ = state.tiles().version();
  }
  if (state.edits().serial() != edits_serial_) {
    text += eventText("edits", editsJson(state.edits()));
    edits_serial_ = state.edits().serial();
  }
  if (isDue(beat_, kBeatPeriod, now))
    text += eventText("beat", {{"silence", rounded(toSeconds(state.silence(now)), 10)}});
  sent_ = sent;
  return text;
}

}  // namespace slam
