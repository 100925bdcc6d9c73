// SPDX-License-Identifier: BSD-3-Clause
// What the emulated lidar answers.
#include <algorithm>
#include <utility>

#include "drivers/lidar/codec/rplidar_modes.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;
using rplidar::ConfigurationEntry;
using rplidar::Request;
using Bytes = std::vector<std::uint8_t>;

constexpr Duration kRequestTimeout = 5s;  // by then all bytes of one must have come
constexpr Duration kSpinUp = 500ms;       // until the motor's speed is stable

template <typename Value>
void append(Bytes& bytes, Value value, std::size_t size = sizeof(Value)) {
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

std::uint16_t u16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

/// Bytes of standard nodes that an earlier program left on the line.
Bytes oldStream(int size) {
  Bytes bytes;
  for (std::uint16_t angle = 320; static_cast<int>(bytes.size()) < size; angle += 64) {
    const auto node = rplidar::encodeStandardNode(
        {.angle_q6 = static_cast<std::uint16_t>(angle % 23040), .distance_q2 = 6000, .quality = 15});
    bytes.insert(bytes.end(), node.begin() + (bytes.empty() ? 2 : 0), node.end());  // it begins within a node
  }
  bytes.resize(static_cast<std::size_t>(size));
  return bytes;
}

}  // namespace

void LidarEmulator::receive(std::span<const std::uint8_t> bytes, Timestamp now, Bytes& out) {
  beginFaults(now);
  if (faults_.silent || faults_.other != OtherLidar::kNone || now < ready_at_) {
    request_.clear();
    return;
  }
  if (now - request_begin_ > kRequestTimeout) request_.clear();
  for (const std::uint8_t byte : bytes) {
    if (request_.empty() && byte != 0xA5) continue;
    if (request_.empty()) request_begin_ = now;
    request_.push_back(byte);
    if (request_.size() < 2) continue;
    const bool has_payload = request_[1] & 0x80;
    if (has_payload && (request_.size() < 3 || request_.size() < 4U + request_[2])) continue;
    std::uint8_t sum = 0;
    for (const std::uint8_t b : request_) sum ^= b;
    if (!has_payload || sum == 0) handle(now, out);
    request_.clear();
  }
}

void LidarEmulator::answer(AnswerType type, const Bytes& data, Bytes& out) {
  const auto descriptor =
      rplidar::encodeDescriptor({static_cast<std::uint32_t>(data.size()), false, static_cast<std::uint8_t>(type)});
  out.insert(out.end(), descriptor.begin(), descriptor.end());
  out.insert(out.end(), data.begin(), data.end());
}

bool LidarEmulator::setMotor(Request request, std::span<const std::uint8_t> payload, Timestamp now) {
  const bool pwm = request == Request::kSetMotorPwm;
  if (!pwm && request != Request::kSetMotorSpeed) return false;
  if (!(pwm ? identity_.accessory_board : hasSpeedControl()) || payload.size() != 2) return true;
  std::uint16_t& motor = pwm ? pwm_ : speed_;
  if (motor == 0) stable_at_ = now + kSpinUp;
  motor = pwm ? std::min<std::uint16_t>(u16(payload, 0), 1023) : u16(payload, 0);
  return true;
}

void LidarEmulator::handle(Timestamp now, Bytes& out) {
  const auto request = static_cast<Request>(request_[1]);
  const Bytes payload(request_.begin() + (request_.size() > 3 ? 3 : 2), request_.end() - (request_.size() > 3 ? 1 : 0));
  if (setMotor(request, payload, now)) return;
  // Any request ends a scan; what is on the line already comes before the answer.
  sampler_.end();
  out.insert(out.end(), line_.begin(), line_.end());
  line_.clear();
  const bool answers = request != Request::kStop && request != Request::kReset;
  if (answers && faults_.stale > 0) {
    const Bytes old = oldStream(std::exchange(faults_.stale, 0));
    out.insert(out.end(), old.begin(), old.end());
  }
  const rplidar::DeviceInfo info{.model = identity_.model, .firmware = identity_.firmware};
  const bool knows_express = rplidar::comparableFirmware(info) >= rplidar::kFirmwareWithExpress;
  switch (request) {
    case Request::kReset:
      return boot(now);
    case Request::kGetInfo: {
      Bytes data{identity_.model};
      append(data, identity_.firmware);
      data.push_back(identity_.hardware);
      for (const char c : std::string_view("SLAMD-SIM-000001")) data.push_back(static_cast<std::uint8_t>(c));
      return answer(AnswerType::kInfo, data, out);
    }
    case Request::kGetHealth:
      return answer(AnswerType::kHealth, {static_cast<std::uint8_t>(faults_.health), 0, 0}, out);
    case Request::kGetSampleRate: {
      Bytes data;
      append(data, identity_.standard_us);
      append(data, identity_.express_us);
      if (knows_express) answer(AnswerType::kSampleRate, data, out);
      return;
    }
    case Request::kGetConfiguration:
      return answerConfiguration(payload, out);
    case Request::kGetAccessoryBoardFlag:
      if (identity_.model >> 4 >= 2) {
        answer(AnswerType::kAccessoryBoardFlag, {static_cast<std::uint8_t>(identity_.accessory_board), 0, 0, 0}, out);
      }
      return;
    case Request::kScan:
      return startScan(AnswerType::kStandardNodes, identity_.standard_us, now, out);
    case Request::kExpressScan: {
      if (!knows_express || payload.size() != 5) return;
      const std::size_t mode = payload[0];
      if (mode == 0) return startScan(AnswerType::kExpressCapsules, identity_.express_us, now, out);  // legacy
      if (mode >= identity_.modes.size() || !identity_.modes[mode].starts) return;
      return startScan(identity_.modes[mode].answer, identity_.modes[mode].sample_us, now, out);
    }
    default:  // STOP and what it does not know
      return;
  }
}

void LidarEmulator::answerConfiguration(std::span<const std::uint8_t> payload, Bytes& out) {
  if (identity_.modes.empty() || payload.size() < 4) return;
  Bytes data(payload.begin(), payload.begin() + 4);
  const auto entry =
      static_cast<ConfigurationEntry>(u16(payload, 0) | static_cast<std::uint32_t>(u16(payload, 2)) << 16);
  const std::size_t id = payload.size() >= 6 ? u16(payload, 4) : identity_.modes.size();
  const bool of_mode = id < identity_.modes.size();
  const LidarMode& mode = identity_.modes[of_mode ? id : 0];
  if (entry == ConfigurationEntry::kModeCount) {
    append(data, static_cast<std::uint16_t>(identity_.modes.size()));
  } else if (entry == ConfigurationEntry::kTypicalMode) {
    append(data, identity_.typical_mode);
  } else if (of_mode && entry == ConfigurationEntry::kSampleTime) {
    append(data, static_cast<std::uint32_t>(mode.sample_us * 256.0));
  } else if (of_mode && entry == ConfigurationEntry::kMaxDistance) {
    append(data, static_cast<std::uint32_t>(mode.max_distance * 256.0));
  } else if (of_mode && entry == ConfigurationEntry::kAnswerType) {
    append(data, mode.listed_type != 0 ? mode.listed_type : static_cast<std::uint8_t>(mode.answer));
  } else if (of_mode && entry == ConfigurationEntry::kModeName) {
    data.insert(data.end(), mode.name.begin(), mode.name.end());
    data.push_back(0);
  } else {
    return;
  }
  answer(AnswerType::kConfiguration, data, out);
}

}  // namespace slam::sim
