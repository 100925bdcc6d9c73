// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/web/web_state.hpp"

/// What the page is sent: server-sent events with JSON in them. Names are short because poses come at 10 Hz.
namespace slam {

nlohmann::json poseJson(const pose_estimate_t& pose);
/// With words and advice for each device.
nlohmann::json healthJson(const health_t& health, const problems_t& problems);
nlohmann::json mapJson(const WebState& state);
/// Points relative to a corner near them: x and y [cm] of the corner, and base64 of int16 pairs [cm].
nlohmann::json pointsJson(const WebState::Points& points);
nlohmann::json trailJson(const WebState& state);

/// JSON that every browser reads, whatever bytes the strings of a message have.
std::string textOf(const nlohmann::json& json);
/// One event of a stream.
std::string eventText(const char* name, const nlohmann::json& data);

/// Follows a state and writes what is new in it as events: once, for all who listen.
class EventFeed {
 public:
  /// @param session another number for each start of the program: the page then forgets what it has
  EventFeed(std::int64_t session, bool commands, std::string version)
      : session_(session), commands_(commands), version_(std::move(version)) {}

  /// For one who comes in now.
  std::string greeting(const WebState& state, Timestamp now) const;
  /// What is new since the last call; called at 10 Hz. Empty: nothing.
  std::string news(const WebState& state, Timestamp now);

 private:
  bool isDue(Timestamp& last, Duration period, Timestamp now) const;

  std::int64_t session_;
  bool commands_;
  std::string version_;
  WebState::Serials sent_;
  std::uint64_t map_version_ = 0;
  Timestamp scan_{}, depth_{}, map_{}, beat_{};
};

}  // namespace slam
