// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scip/scip_unit.hpp"

#include <algorithm>
#include <utility>

#include "drivers/lidar/scip/scip_decoder.hpp"
#include "drivers/lidar/text/text_answer.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kScipAnswer = 500ms;        // to a command
constexpr Duration kLastScipQuestion = 250ms;  // to a silent unit: the thread that reads it waits meanwhile
constexpr Duration kScipQuiet = 100ms;         // after the end of an old scan

bool isAny(const std::string& status, std::initializer_list<const char*> values) {
  return std::find(values.begin(), values.end(), status) != values.end();
}

}  // namespace

void ScipUnit::send(const std::string& command) { sendText(*port_, command + "\n"); }

std::optional<scip::Answer> ScipUnit::ask(const std::string& command, Duration limit) {
  send(command);
  return awaitText(
      *dialogue_, now_, limit,
      [&](std::string_view text, std::size_t& size) { return scip::findAnswer(text, command, size); }, read_ahead_);
}

/// Ends an old scan, and asks who it is.
std::optional<scip::Answer> ScipUnit::identify() {
  send("QT");
  dialogue_->drain(kScipQuiet, 10 * kScipQuiet);
  if (auto version = ask("VV", kScipAnswer)) return version;
  send("SCIP2.0");  // an old URG-04LX begins with SCIP 1.1
  dialogue_->drain(kScipQuiet, 10 * kScipQuiet);
  return ask("VV", kScipAnswer);
}

ScipUnit::Begun ScipUnit::begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) {
  port_ = &port;
  dialogue_ = std::make_unique<rplidar::Dialogue>(port, now_, &cancel);
  const auto version = identify();
  if (!version) return unanswered(*dialogue_, others);
  others.forget();
  const auto parameters = ask("PP", kScipAnswer);
  const auto unit = parameters ? scip::parseParameters(*parameters) : std::nullopt;
  if (!unit)
    return dialogue_->hungUp() ? unanswered(*dialogue_, others) : Begun{DeviceState::kFault, problem::kLidarUnknown};
  const auto laser = ask("BM", kScipAnswer);
  if (!laser || !isAny(laser->status, {"00", "02"})) return {DeviceState::kFault, problem::kLidarNoScan};
  Begun begun = startScan(*unit);
  begun.identity = "Hokuyo " + unit->model + ", firmware " + scip::valueOf(*version, "FIRM") + ", serial number " +
                   scip::valueOf(*version, "SERI");
  dialogue_ = std::make_unique<rplidar::Dialogue>(port, now_, nullptr);  // `cancel` may not live longer
  return begun;
}

ScipUnit::Begun ScipUnit::startScan(const scip::Parameters& unit) {
  const std::string command = scip::scanCommand(unit);
  const auto answer = ask(command, kScipAnswer);
  if (!answer || answer->status != "00") return {DeviceState::kFault, problem::kLidarNoScan};
  constexpr double kFastLine = 1e-6;  // [s] of a byte on USB at full speed; on Ethernet it is less
  const double byte_time = config_.baud > 0 ? 10.0 / config_.baud : kFastLine;
  const float least = 1e-3F * static_cast<float>(unit.least_mm), most = 1e-3F * static_cast<float>(unit.most_mm);
  Begun begun;
  begun.start.scans = std::make_unique<LidarScanStream>(
      std::make_unique<ScipDecoder>(unit, command, byte_time),
      LidarScanStream::Format{.sample_time = unit.stepTime(),
                              .byte_time = byte_time,
                              .limits = {.range_min = std::max(config_.limits.min, least),
                                         .range_max = std::min(config_.limits.max, most),
                                         .clockwise = false,
                                         .exact_bearings = true}});
  begun.start.read_ahead = std::move(read_ahead_);
  begun.start.pause = fromSeconds(unit.turnTime());
  return begun;
}

/// The port is there, so ask the unit how it is before giving up.
Problem ScipUnit::silence(const LidarReader& scan) {
  const auto state = ask("II", kLastScipQuestion);
  if (dialogue_->hungUp()) return problem::kPortGone;
  if (!state) return problem::kLidarSilent;
  if (scan.nodes() == 0 && scan.bytes() > 0) return problem::kLidarGarbage;
  const std::string words = scip::valueOf(*state, "STAT");
  return {problem::kLidarStopped, {}, {words.empty() ? "nothing of its state" : words}};
}

void ScipUnit::end() {
  if (port_ == nullptr) return;
  send("QT");  // which turns the laser off
  dialogue_.reset();
  port_ = nullptr;
}

}  // namespace slam
