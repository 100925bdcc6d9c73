// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/search/lidar_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "drivers/lidar/codec/cola_codec.hpp"
#include "drivers/lidar/codec/scip_codec.hpp"
#include "drivers/lidar/packet_decoder.hpp"
#include "drivers/lidar/packet_lidar.hpp"
#include "drivers/lidar/text/text_answer.hpp"
#include "drivers/tcp_port.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;

// The most frequent ones first.
constexpr std::array kSending = {230400, 115200, 921600, 128000};    // [bit/s] of lidars that send unasked
constexpr std::array kRplidars = {115200, 460800, 1000000, 256000};  // [bit/s] these are asked
constexpr std::array kYdlidars = {128000, 230400};                   // [bit/s] of those that wait for a command
constexpr Duration kListen = 400ms;                                  // at each: two turns and more
constexpr Duration kProbeAnswer = 300ms;                             // to a question
constexpr Duration kSpinUp = 3s;    // from its command to the packets of a lidar that is started
constexpr double kSameRate = 0.06;  // [1] of the samples' rate: the models of one family are 10 % apart

LidarFinding foundRow(const LidarFacts* row, int baud) {
  return row == nullptr ? LidarFinding{} : LidarFinding{LidarFinding::kPackets, row, baud};
}

}  // namespace

const LidarFacts* ydlidarOf(int model) {
  constexpr std::pair<int, const char*> kModels[] = {
      {5, "ydlidar-g4"},       {6, "ydlidar-x4"},       {15, "ydlidar-g2"},     {140, "ydlidar-t-mini"},
      {150, "ydlidar-t-mini"}, {151, "ydlidar-t-mini"}, {152, "ydlidar-t-mini"}};
  for (const auto& [number, driver] : kModels) {
    if (number == model) return findLidar(driver);
  }
  return nullptr;
}

/// Opens the port at each baud rate, until `look` has found something. @return whether to go on
template <typename Look>
bool LidarSearch::tryEach(std::span<const int> bauds, const std::atomic<bool>& cancel, const Look& look) {
  for (const int baud : bauds) {
    if (baud_ > 0 && baud != baud_) continue;
    if (cancel) break;
    OpenedPort port = open_(path_, baud);
    if (!port.stream) {
      found_ = {.problem = port.problem, .is_open = false};
      return false;
    }
    port.stream->discardInput();
    rplidar::Dialogue dialogue(*port.stream, now_, &cancel);
    found_ = look(dialogue, baud);
    if (found_.family != LidarFinding::kNone) return false;
    has_bytes_ = has_bytes_ || dialogue.receivedBytes();
    if (dialogue.hungUp()) found_ = {.problem = problem::kPortGone, .is_open = false};
    if (dialogue.hungUp()) return false;
    found_.other = lineDeviceOf(dialogue.recent());
    found_.other.baud = baud;
    if (isOtherDevice(found_.other.line_device)) return false;  // which is to be asked nothing
  }
  return !cancel;
}

LidarFinding LidarSearch::find(const std::atomic<bool>& cancel) {
  const LidarFinding passive = listen(cancel);
  return passive.isDecided() || cancel ? passive : ask(cancel);
}

LidarFinding LidarSearch::listen(const std::atomic<bool>& cancel) {
  found_ = {};
  has_bytes_ = false;
  const auto packets = [this](auto& dialogue, int baud) { return receivePackets(dialogue, baud); };
  if (!isTcp(path_)) tryEach(kSending, cancel, packets);
  return finish(cancel);
}

LidarFinding LidarSearch::ask(const std::atomic<bool>& cancel) {
  found_ = {};
  const auto text = [this](auto& dialogue, int baud) { return askText(dialogue, baud); };
  if (isTcp(path_)) {
    tryEach(std::array{baud_}, cancel, text);
  } else {
    const std::array one = {baud_};
    const bool other_baud = baud_ > 0 && std::find(kSending.begin(), kSending.end(), baud_) == kSending.end();
    const auto rplidars = [this](auto& dialogue, int baud) { return askRplidar(dialogue, baud); };
    tryEach(other_baud ? std::span<const int>(one) : kRplidars, cancel, rplidars) &&
        tryEach(kYdlidars, cancel, [this](auto& dialogue, int baud) { return askYdlidar(dialogue, baud); }) &&
        tryEach(std::span<const int>(kRplidars).first(1), cancel, text);
  }
  return finish(cancel);
}

LidarFinding LidarSearch::wake(const std::atomic<bool>& cancel) {
  // By its command that is the more harmless: a single letter means something to many a device.
  constexpr std::array kSleepers = {"coin-d4", "lds01"};
  found_ = {};
  for (const char* driver : kSleepers) {
    const LidarFacts& row = *findLidar(driver);
    OpenedPort port = open_(path_, row.baud);
    if (!port.stream) {
      found_ = {.problem = port.problem, .is_open = false};
      break;
    }
    rplidar::Dialogue dialogue(*port.stream, now_, &cancel);
    row.talk.start(dialogue);
    found_ = listenTo(dialogue, row.baud, kSpinUp);
    row.talk.stop(*port.stream);
    // Others of its family send alike, but do not begin by this command.
    if (found_.facts != nullptr && found_.facts->line_device == row.line_device) found_.facts = &row;
    if (found_.family != LidarFinding::kNone || dialogue.hungUp() || cancel) break;
  }
  return finish(cancel);
}

LidarFinding LidarSearch::finish(const std::atomic<bool>& cancel) {
  found_.has_bytes = has_bytes_;
  if (found_.family == LidarFinding::kNone && !found_.problem)
    found_.problem = cancel ? problem::kStoppedOpening : has_bytes_ ? problem::kLidarNotFound : problem::kLidarUnheard;
  return found_;
}

LidarFinding LidarSearch::receivePackets(rplidar::Dialogue& dialogue, int baud) {
  return listenTo(dialogue, baud, kListen);
}

/// @param limit a lidar that has begun is known kListen after its first byte
LidarFinding LidarSearch::listenTo(rplidar::Dialogue& dialogue, int baud, Duration limit) {
  struct Candidate {
    const LidarFacts* row;
    PacketDecoder decoder;
    int best = 0;  // packets in a row
    std::size_t nodes = 0;
  };
  std::vector<Candidate> candidates;
  for (const LidarFacts& row : lidarTable()) {
    if (row.baud == baud) candidates.push_back({&row, PacketDecoder(*row.packets, 1.0 / row.sample_rate, 10.0 / baud)});
  }
  std::vector<TimedNode> nodes;
  Timestamp end = now_() + limit, begun{};
  while (now_() < end && !dialogue.hungUp() && !dialogue.cancelled()) {
    for (const std::uint8_t byte : dialogue.readOn(end - now_())) {
      for (Candidate& candidate : candidates) {
        nodes.clear();
        candidate.decoder.push(byte, nodes);
        candidate.nodes += nodes.size();
        candidate.best = std::max(candidate.best, candidate.decoder.inARow());
        // The rate of its samples is measured from its first packet on.
        if (begun == Timestamp{} && candidate.best > 0) end = std::min(end, (begun = now_()) + kListen);
      }
    }
  }
  // Where the rates are alike, too, one that sends unasked.
  const auto off = [](const Candidate& candidate) {
    const double rate = static_cast<double>(candidate.nodes) / toSeconds(kListen);
    return std::abs(rate / candidate.row->sample_rate - 1.0) + (candidate.row->talk.start != nullptr ? kSameRate : 0.0);
  };
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates) {
    if (candidate.best >= PacketLidar::kEnough && (best == nullptr || off(candidate) < off(*best))) best = &candidate;
  }
  if (best == nullptr) return {};
  if (best->row->line_device == LineDevice::kYdlidar) {  // it may say who it is
    const LidarFinding answer = askYdlidar(dialogue, baud);
    if (answer.facts != nullptr && answer.facts->packets == best->row->packets) return answer;
  }
  return foundRow(best->row, baud);
}

LidarFinding LidarSearch::askRplidar(rplidar::Dialogue& dialogue, int baud) const {
  const auto info =
      dialogue.ask(rplidar::encodeRequest(rplidar::Request::kGetInfo), AnswerType::kInfo, 20, kProbeAnswer);
  return info.empty() ? LidarFinding{} : LidarFinding{LidarFinding::kRplidar, nullptr, baud};
}

LidarFinding LidarSearch::askYdlidar(rplidar::Dialogue& dialogue, int baud) const {
  constexpr std::array<std::uint8_t, 2> kWho = {0xA5, 0x90};
  const auto info = dialogue.ask(kWho, AnswerType::kInfo, 20, kProbeAnswer);
  return info.empty() ? LidarFinding{} : foundRow(ydlidarOf(info[0]), baud);
}

LidarFinding LidarSearch::askText(rplidar::Dialogue& dialogue, int baud) const {
  std::vector<std::uint8_t> behind;
  constexpr std::string_view kVersion = "\nVV\n";
  dialogue.send({reinterpret_cast<const std::uint8_t*>(kVersion.data()), kVersion.size()});
  const auto scip = awaitText(
      dialogue, now_, kProbeAnswer,
      [](std::string_view text, std::size_t& size) { return scip::findAnswer(text, "VV", size); }, behind);
  if (scip && !scip::valueOf(*scip, "VEND").empty()) return {LidarFinding::kHokuyo, nullptr, baud};
  if (!isTcp(path_)) return {};
  const std::string who = cola::telegram("sRN DeviceIdent");
  dialogue.send({reinterpret_cast<const std::uint8_t*>(who.data()), who.size()});
  const auto sick = awaitText(
      dialogue, now_, kProbeAnswer,
      [](std::string_view text, std::size_t& size) { return cola::findTelegram(text, "sRA DeviceIdent", "sFA", size); },
      behind);
  return sick ? LidarFinding{LidarFinding::kSick, nullptr, baud} : LidarFinding{};
}

}  // namespace slam
