// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/packet_lidar.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "drivers/lidar/packet_decoder.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kWake = 3s;  // from power-on to the first packet at its motor's speed; the makers wait as long

}  // namespace

PacketLidar::Begun PacketLidar::begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) {
  port_ = &port;
  if (facts_.motor_by_dtr) port.setDtr(true);
  rplidar::Dialogue dialogue(port, now_, &cancel);
  LidarTalk::Answer answer;
  if (facts_.talk.start != nullptr) answer = facts_.talk.start(dialogue);
  if (answer.fault) return {DeviceState::kFault, answer.problem};
  Begun begun = listen(dialogue, others);
  if (begun.state != DeviceState::kStreaming) return begun;
  others.forget();
  const double sample_time = 1.0 / facts_.sample_rate, byte_time = 10.0 / config_.baud;  // [s]
  RangeLimits limits = config_.limits;
  limits.min = std::max(limits.min, facts_.range.min);
  limits.max = std::min(limits.max, facts_.range.max);
  begun.problem = answer.problem;
  begun.identity = facts_.name + answer.identity;
  begun.start.scans = std::make_unique<LidarScanStream>(
      std::make_unique<PacketDecoder>(*facts_.packets, sample_time, byte_time),
      LidarScanStream::Format{
          .sample_time = sample_time, .byte_time = byte_time, .limits = {limits.min, limits.max, facts_.clockwise}});
  return begun;
}

/// Reads until it is this lidar, or has not been for long.
PacketLidar::Begun PacketLidar::listen(rplidar::Dialogue& dialogue, WrongDevice& others) const {
  PacketDecoder decoder(*facts_.packets, 1.0 / facts_.sample_rate, 10.0 / config_.baud);
  std::vector<TimedNode> nodes;
  int best = 0;
  for (const Timestamp end = now_() + kWake; best < kEnough && now_() < end;) {
    if (dialogue.hungUp()) return {DeviceState::kAbsent, problem::kPortGone};
    if (dialogue.cancelled()) return {DeviceState::kAbsent, problem::kStoppedOpening};
    for (const std::uint8_t byte : dialogue.readOn(end - now_())) {
      nodes.clear();
      decoder.push(byte, nodes);
      best = std::max(best, decoder.inARow());
    }
  }
  if (best >= kEnough) return {};
  if (others.recognises(dialogue.recent())) return {DeviceState::kFault, problem::kLidarNoPackets, true};
  if (dialogue.receivedBytes()) return {DeviceState::kFault, problem::kLidarNoPackets, true};
  return {DeviceState::kFault, facts_.talk.start != nullptr ? problem::kLidarUnanswered : problem::kLidarUnheard, true};
}

Problem PacketLidar::silence(const LidarReader& scan) {
  constexpr Duration kStillComing = 100ms;  // since the last byte
  const bool receiving = scan.bytes() > 0 && now_() - scan.lastArrival() < kStillComing;
  return receiving ? problem::kLidarNoPackets : problem::kLidarUnheard;
}

void PacketLidar::end() {
  if (port_ == nullptr) return;
  if (facts_.talk.stop != nullptr) facts_.talk.stop(*port_);
  if (facts_.motor_by_dtr) port_->setDtr(false);
  port_ = nullptr;
}

}  // namespace slam
