// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/history/day_history.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "drivers/device_status.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam {
namespace {

constexpr const char *kState = "state", *kDrive = "drive", *kDevice = "device", *kMark = "mark";
constexpr std::size_t kMostOpen = 16;          // devices of a robot, its pose and its drive
constexpr std::size_t kLongestName = 200;      // [bytes]
constexpr std::size_t kLongestProblem = 2000;  // [bytes] slamd's own have some hundreds
constexpr double kLongestStep = 0.5;           // [m] between two poses; more is a jump, and no way

const problem_t* problemOf(const problems_t& problems, const std::string& device) {
  const auto at = std::find_if(problems.problems.begin(), problems.problems.end(),
                               [&](const problem_t& problem) { return problem.device == device; });
  return at == problems.problems.end() ? nullptr : &*at;
}

bool isTime(std::int64_t utime) { return utime > 0 && utime < std::numeric_limits<std::int64_t>::max() / 4000; }

bool isShort(const problem_t& problem) {
  std::size_t size = problem.device.size() + problem.id.size() + problem.cause.size() + problem.meanwhile.size() +
                     problem.fix.size() + sizeof(double) * problem.numbers.size();
  for (const std::string& text : problem.texts) size += sizeof text + text.size();
  return size <= kLongestProblem;
}

/// The first one of the highest level is what it began with; later ones are steps of the way back.
void blame(DayHistory::Happening& happening, const problem_t* problem) {
  if (problem != nullptr && isShort(*problem) && (!happening.problem || problem->level > happening.problem->level))
    happening.problem = *problem;
}

/// @return 0 for what is no integer
std::int64_t integerOf(const nlohmann::json& json) { return json.is_number_integer() ? json.get<std::int64_t>() : 0; }

problem_t problemOf(const nlohmann::json& json) {
  problem_t problem{};
  problem.device = json.at("device"), problem.id = json.at("id");
  problem.level = json.at("level") == "fault" ? 2 : 1;
  problem.numbers = json.at("numbers").get<std::vector<double>>(), problem.texts = json.at("texts");
  problem.nnumbers = static_cast<std::int32_t>(problem.numbers.size());
  problem.ntexts = static_cast<std::int32_t>(problem.texts.size());
  problem.cause = json.at("cause"), problem.meanwhile = json.at("meanwhile"), problem.fix = json.at("fix");
  return problem;
}

DayHistory::Happening happeningOf(const nlohmann::json& json) {
  DayHistory::Happening one{.kind = json.at("kind"),
                            .begin = integerOf(json.at("begin")),
                            .end = integerOf(json.at("end")),
                            .name = json.at("name"),
                            .map_id = static_cast<std::int32_t>(integerOf(json.at("map"))),
                            .x = json.at("x"),
                            .y = json.at("y"),
                            .metres = json.at("metres"),
                            .problem = std::nullopt};
  if (!json.at("problem").is_null()) one.problem = problemOf(json.at("problem"));
  return one;
}

bool canBe(const DayHistory::Happening& one, std::int64_t newest) {
  constexpr std::array kKinds{kState, kDevice, kDrive, kMark};
  return std::find(kKinds.begin(), kKinds.end(), one.kind) != kKinds.end() && isTime(one.begin) &&
         one.begin <= one.end && one.end <= newest && one.name.size() <= kLongestName &&
         (!one.problem || isShort(*one.problem));
}

}  // namespace

bool DayHistory::advance(std::int64_t utime) {
  constexpr std::int64_t kSetBack = 1'000'000;  // [us] a clock that was set
  if (since_ == 0 || utime < utime_ - kSetBack) {
    ended_.clear();
    open_.clear();
    pose_.reset();
    since_ = utime_ = utime;
  }
  utime_ = std::max(utime_, utime);
  while (!ended_.empty() && ended_.front().end < utime_ - kPeriod) ended_.pop_front();
  since_ = std::max(since_, utime_ - kPeriod);
  return utime == utime_;
}

void DayHistory::begin(const std::string& key, const std::string& kind, const std::string& name, std::int64_t at) {
  if (open_.size() >= kMostOpen || open_.contains(key)) return;
  Happening happening{
      .kind = kind, .begin = at, .end = at, .name = name.substr(0, kLongestName), .problem = std::nullopt};
  if (pose_) happening.map_id = pose_->map_id, happening.x = pose_->x, happening.y = pose_->y;
  open_.emplace(key, std::move(happening));
}

void DayHistory::end(const std::string& key, std::int64_t at) {
  auto ended = open_.extract(key);
  if (!ended) return;
  ended.mapped().end = std::max(at, ended.mapped().begin);
  keep(std::move(ended.mapped()));
}

void DayHistory::keep(Happening happening) {
  ended_.push_back(std::move(happening));
  if (ended_.size() <= kMost) return;
  since_ = std::max(since_, ended_.front().end);
  ended_.pop_front();
}

void DayHistory::take(const pose_estimate_t& pose) {
  if (!isTime(pose.utime) || !advance(pose.utime)) return;
  if (pose_ && pose.utime - pose_->utime > kSilence) {
    end(kState, pose_->utime), end(kDrive, pose_->utime);
    begin(kState, kState, "silent", pose_->utime);
    end(kState, pose.utime);
  }
  const std::string state = stateName(static_cast<std::int8_t>(pose.state));
  const double step = pose_ && pose_->map_id == pose.map_id ? std::hypot(pose.x - pose_->x, pose.y - pose_->y) : 0.0;
  pose_ = pose;
  if (const auto now = open_.find(kState); now != open_.end() && now->second.name != state) end(kState, pose.utime);
  begin(kState, kState, state, pose.utime);
  const bool moves = std::abs(pose.twist[0]) > kMoves || std::abs(pose.twist[2]) > kTurns;
  if (moves) begin(kDrive, kDrive, "", pose.utime), moved_ = pose.utime;
  if (const auto drive = open_.find(kDrive); drive != open_.end()) {
    if (moves && step < kLongestStep) drive->second.metres += step;
    if (pose.utime - moved_ > kPause) end(kDrive, moved_);
  }
}

void DayHistory::take(const health_t& health, const problems_t& problems) {
  if (!isTime(health.utime)) return;
  advance(health.utime);
  for (const device_health_t& device : health.devices) {
    const std::string key = std::string(kDevice) + " " + device.name;
    const bool away = static_cast<DeviceState>(static_cast<std::uint8_t>(device.state)) != DeviceState::kStreaming;
    if (!away) end(key, utime_);
    if (away) begin(key, kDevice, device.name, utime_);
    if (const auto open = open_.find(key); open != open_.end()) {
      blame(open->second, problemOf(problems, device.name));
    }
  }
  if (const auto state = open_.find(kState); state != open_.end() && state->second.name != "localised") {
    blame(state->second, problemOf(problems, "pose"));
  }
}

void DayHistory::mark(const std::string& words) {
  if (since_ == 0) return;  // nothing came yet: it has no time
  begin(kMark, kMark, words, utime_);
  end(kMark, utime_);
}

std::deque<DayHistory::Happening> DayHistory::all() const {
  std::deque<Happening> list = ended_;
  for (const auto& [key, happening] : open_) {
    list.push_back(happening);
    list.back().end = utime_;
  }
  return list;
}

nlohmann::json historyJson(const DayHistory& history) {
  auto list = nlohmann::json::array();
  for (const DayHistory::Happening& one : history.all())
    list.push_back({{"kind", one.kind},
                    {"begin", one.begin},
                    {"end", one.end},
                    {"name", one.name},
                    {"map", one.map_id},
                    {"x", rounded(one.x, 1e2)},
                    {"y", rounded(one.y, 1e2)},
                    {"metres", rounded(one.metres, 10)},
                    {"problem", one.problem ? problemJson(*one.problem) : nlohmann::json()}});
  return {{"since", history.since()}, {"now", history.newest()}, {"happenings", std::move(list)}};
}

std::optional<DayHistory> historyOf(const nlohmann::json& json) try {
  const std::int64_t since = integerOf(json.at("since")), newest = integerOf(json.at("now"));
  const auto& list = json.at("happenings");
  if (!isTime(since) || !isTime(newest) || since > newest || !list.is_array() ||
      list.size() > DayHistory::kMost + kMostOpen)
    return std::nullopt;
  std::deque<DayHistory::Happening> happenings;
  for (const auto& one : list) {
    happenings.push_back(happeningOf(one));
    if (!canBe(happenings.back(), newest)) return std::nullopt;
  }
  return DayHistory(since, newest, std::move(happenings));
} catch (const nlohmann::json::exception&) {
  return std::nullopt;
}

}  // namespace slam
