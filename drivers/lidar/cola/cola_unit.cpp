// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/cola/cola_unit.hpp"

#include <utility>

#include "drivers/lidar/codec/cola_codec.hpp"
#include "drivers/lidar/cola/cola_decoder.hpp"
#include "drivers/lidar/text/text_answer.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAnswer = 1s;           // to a request: of a scan it comes with the next turn
constexpr Duration kLastQuestion = 250ms;  // to a silent unit: the thread that reads it waits meanwhile
constexpr Duration kQuiet = 150ms;         // two turns of the slowest, after the end of an old scan
constexpr std::string_view kError = "sFA", kStop = "sEN LMDscandata 0", kIdentity = "sRA DeviceIdent ";

}  // namespace

std::optional<std::string> ColaUnit::ask(std::string_view request, std::string_view answer, Duration limit) {
  sendText(*port_, cola::telegram(request));
  auto found = awaitText(
      *dialogue_, now_, limit,
      [&](std::string_view text, std::size_t& size) { return cola::findTelegram(text, answer, kError, size); },
      read_ahead_);
  return found && found->starts_with(kError) ? std::nullopt : found;
}

ColaUnit::Begun ColaUnit::begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) {
  port_ = &port;
  dialogue_ = std::make_unique<rplidar::Dialogue>(port, now_, &cancel);
  sendText(port, cola::telegram(kStop));
  dialogue_->drain(kQuiet, 10 * kQuiet);
  const auto identity = ask("sRN DeviceIdent", kIdentity, kAnswer);
  const auto scan = identity ? ask("sRN LMDscandata", "sRA LMDscandata", kAnswer) : std::nullopt;
  if (!identity || dialogue_->hungUp() || dialogue_->cancelled()) return unanswered(*dialogue_, others);
  others.forget();
  if (!scan) return {DeviceState::kFault, problem::kLidarNoScan};
  Begun begun = startScan(*scan);
  begun.identity = "SICK " + identity->substr(kIdentity.size());
  dialogue_ = std::make_unique<rplidar::Dialogue>(port, now_, nullptr);  // `cancel` may not live longer
  return begun;
}

ColaUnit::Begun ColaUnit::startScan(const std::string& telegram) {
  const auto scan = cola::parseScan(telegram);
  if (!scan) return {DeviceState::kFault, problem::kLidarUnknown};
  if (!ask("sEN LMDscandata 1", "sEA LMDscandata 1", kAnswer)) return {DeviceState::kFault, problem::kLidarNoScan};
  constexpr double kByteTime = 0.0;  // [s] Ethernet carries a scan in less than a millisecond
  Begun begun;
  if (scan->contamination != cola::Contamination::kNone) begun.problem = problem::kLidarWarns;
  begun.start.scans = std::make_unique<LidarScanStream>(
      std::make_unique<ColaDecoder>(*scan, kByteTime),
      LidarScanStream::Format{
          .sample_time = scan->stepTime(),
          .byte_time = kByteTime,
          .limits = {.range_min = limits_.min, .range_max = limits_.max, .clockwise = false, .exact_bearings = true}});
  begun.start.read_ahead = std::move(read_ahead_);
  begun.start.pause = fromSeconds(scan->turn_time);
  return begun;
}

/// It is connected, so ask the unit how it is before giving up.
Problem ColaUnit::silence(const LidarReader& scan) {
  const auto state = ask("sRN SCdevicestate", "sRA SCdevicestate ", kLastQuestion);
  if (dialogue_->hungUp()) return problem::kPortGone;
  if (!state) return problem::kLidarSilent;
  if (scan.nodes() == 0 && scan.bytes() > 0) return problem::kLidarGarbage;
  const char code = state->back();
  return {problem::kLidarStopped,
          {},
          {code == '0'   ? "busy"
           : code == '1' ? "ready"
           : code == '2' ? "an error"
                         : "nothing of its state"}};
}

void ColaUnit::end() {
  if (port_ == nullptr) return;
  sendText(*port_, cola::telegram(kStop));
  dialogue_.reset();
  port_ = nullptr;
}

}  // namespace slam
