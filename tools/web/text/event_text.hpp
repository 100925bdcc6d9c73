// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "tools/web/web_state.hpp"

/// What the page is sent: server-sent events with JSON in them. Names are short because poses come at 10 Hz.
namespace slam {

nlohmann::json mapJson(const WebState& state);
/// Points relative to a corner near them: x and y [cm] of the corner, and base64 of int16 pairs [cm].
nlohmann::json pointsJson(const WebState::Points& points);
nlohmann::json trailJson(const WebState& state);

/// One event of a stream.
std::string eventText(const char* name, const nlohmann::json& data);

/// Follows a state and writes what is new in it as events: once, for all who listen.
class EventFeed {
 public:
  /// @param session another number for each start of the program: the page then forgets what it has
  /// @param limits of the speeds that may be asked for; std::nullopt: none may
  EventFeed(std::int64_t session, bool commands, std::string version, std::optional<SpeedLimits> limits = std::nullopt)
      : session_(session), commands_(commands), version_(std::move(version)), limits_(limits) {}

  /// For one who comes in now.
  std::string greeting(const WebState& state, Timestamp now) const;
  /// What is new since the last call; called at 10 Hz. Empty: nothing.
  std::string news(const WebState& state, Timestamp now);

 private:
  bool isDue(Timestamp& last, Duration period, Timestamp now) const;

  std::int64_t session_;
  bool commands_;
  std::string version_;
  std::optional<SpeedLimits> limits_;
  WebState::Serials sent_;
  std::uint64_t map_version_ = 0, edits_serial_ = 0;
  Timestamp scan_{}, depth_{}, map_{}, beat_{};
};

}  // namespace slam
