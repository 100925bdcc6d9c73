// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <slam/health_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problems_t.hpp>
#include <string>
#include <utility>

namespace slam {

/// What happened to the robot over the last day, as far as slam-web ran: states of the pose, devices that were away,
/// drives, and marks of the log. Its memory is bounded whatever comes. Times are those of slamd's messages. Pure.
class DayHistory {
 public:
  static constexpr std::int64_t kPeriod = 86'400'000'000;  ///< [us]
  static constexpr std::size_t kMost = 3000;            ///< that are kept; then the oldest go before their day is over
  static constexpr std::int64_t kSilence = 3'000'000;   ///< [us] without a pose: slamd was silent
  static constexpr std::int64_t kPause = 10'000'000;    ///< [us] a drive ends when the robot has stood for so long
  static constexpr double kMoves = 0.03, kTurns = 0.1;  ///< [m/s], [rad/s] the robot drives

  struct Happening {
    std::string kind;                  ///< "state", "device", "drive" or "mark"
    std::int64_t begin = 0, end = 0;   ///< [us since the epoch]
    std::string name;                  ///< of the state or device; words of a mark; empty: of a drive
    std::int32_t map_id = 0;           ///< of the place
    double x = 0.0, y = 0.0;           ///< [m] where the robot was, when it began
    double metres = 0.0;               ///< [m] of a drive
    std::optional<problem_t> problem;  ///< what was wrong
  };

  DayHistory() = default;
  /// What was kept before slam-web ended. @param since, newest [us since the epoch] as the functions of these names
  DayHistory(std::int64_t since, std::int64_t newest, std::deque<Happening> ended)
      : ended_(std::move(ended)), since_(since), utime_(newest) {}

  void take(const pose_estimate_t& pose);
  void take(const health_t& health, const problems_t& problems);
  /// A person marks the log now.
  void mark(const std::string& words);

  /// [us since the epoch] what was before is not in it; 0: nothing came yet.
  std::int64_t since() const { return since_; }
  std::int64_t newest() const { return utime_; }  ///< [us since the epoch] of the newest message
  /// Ended ones and those that last, by their ends.
  const std::deque<Happening>& ended() const { return ended_; }
  std::deque<Happening> all() const;

 private:
  void begin(const std::string& key, const std::string& kind, const std::string& name, std::int64_t at);
  void end(const std::string& key, std::int64_t at);
  void keep(Happening happening);
  bool advance(std::int64_t utime);

  std::deque<Happening> ended_;
  std::map<std::string, Happening> open_;  // by what it is about
  std::optional<pose_estimate_t> pose_;
  std::int64_t since_ = 0, utime_ = 0, moved_ = 0;  // [us since the epoch]
};

/// As docs/api.md has it.
nlohmann::json historyJson(const DayHistory& history);
/// The same back. @return std::nullopt where something in it cannot be
std::optional<DayHistory> historyOf(const nlohmann::json& json);

}  // namespace slam
