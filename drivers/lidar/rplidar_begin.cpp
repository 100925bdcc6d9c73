// SPDX-License-Identifier: BSD-3-Clause
// RplidarUnit::begin(): from an opened port to a running scan.
#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "drivers/lidar/rplidar_scan_stream.hpp"
#include "drivers/lidar/rplidar_unit.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;
using rplidar::ConfigurationEntry;
using rplidar::HealthStatus;
using rplidar::Request;

constexpr Duration kRplidarQuiet = 100ms;   // after an answer that did not come
constexpr Duration kRplidarAnswer = 500ms;  // to a request
constexpr Duration kBoot = 1s;              // after a reset; 0.67 s were measured
constexpr double kBusyLine = 0.8;           // share of the time that it carries bytes
constexpr int kResets = 3;                  // then the unit is at fault
constexpr int kFirstWithMotorSpeed = 6;     // of the series: the S units have a speed control of their own

std::string identityOf(const rplidar::DeviceInfo& info, const rplidar::ScanMode& mode) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), ", firmware %d.%02d, hardware %d, serial number ", info.firmware >> 8,
                info.firmware & 0xFF, info.hardware);
  std::string words = rplidar::modelName(info.model) + text.data();
  for (const std::uint8_t byte : info.serial) {
    std::snprintf(text.data(), text.size(), "%02X", static_cast<unsigned>(byte));
    words += text.data();
  }
  const char* name = mode.name[0] != '\0' ? mode.name.data() : mode.by_express ? "Express" : "Standard";
  std::snprintf(text.data(), text.size(), ", mode %s (%02X), %.1f us a sample", name,
                static_cast<unsigned>(mode.answer_type), 1e6 * mode.sample_time);
  return words + text.data();
}

}  // namespace

std::vector<std::uint8_t> RplidarUnit::ask(Request request, AnswerType type, std::size_t size) {
  return dialogue_->ask(rplidar::encodeRequest(request), type, size, kRplidarAnswer);
}

std::optional<rplidar::Health> RplidarUnit::askHealth(Duration timeout) {
  return rplidar::parseHealth(
      dialogue_->ask(rplidar::encodeRequest(Request::kGetHealth), AnswerType::kHealth, 3, timeout));
}

RplidarUnit::Begun RplidarUnit::begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) {
  port_ = &port;
  dialogue_ = std::make_unique<rplidar::Dialogue>(port, now_, &cancel);
  quiet();
  Begun begun = identify(others);
  if (begun.state == DeviceState::kStreaming) begun = startScan();
  if (begun.state == DeviceState::kStreaming)
    dialogue_ = std::make_unique<rplidar::Dialogue>(port, now_, nullptr);  // `cancel` may not live longer
  return begun;
}

void RplidarUnit::quiet() {
  port_->setDtr(true);  // motor off: a stale stream of an earlier run must not go on
  dialogue_->send(rplidar::encodeRequest(Request::kStop));
  dialogue_->drain(kAfterStop, 1s);
}

RplidarUnit::Begun RplidarUnit::identify(WrongDevice& others) {
  for (int attempt = 0; attempt <= kResets && !dialogue_->cancelled(); ++attempt) {
    const auto health = askHealth(kRplidarAnswer);
    const bool error = health && health->status == HealthStatus::kError;
    const auto info = health ? rplidar::parseInfo(ask(Request::kGetInfo, AnswerType::kInfo, 20)) : std::nullopt;
    if (info && !error) {
      others.forget();
      info_ = *info;
      warning_ = health->status == HealthStatus::kWarning ? problem::kLidarWarns : Problem();
      askRate();
      askModes();
      askMotor();
      return {};
    }
    if (dialogue_->hungUp() || attempt == kResets || others.recognises(dialogue_->recent())) return noAnswer(health);
    if (dialogue_->cancelled()) break;
    if (attempt > 0 || error) {
      dialogue_->send(rplidar::encodeRequest(Request::kReset));
      dialogue_->awaitBoot(kBoot);
    }
    dialogue_->drain(error ? kAfterStop : kRplidarQuiet, kBoot);
  }
  return {DeviceState::kAbsent, problem::kStoppedOpening};
}

RplidarUnit::Begun RplidarUnit::noAnswer(const std::optional<rplidar::Health>& health) const {
  if (dialogue_->hungUp()) return {DeviceState::kAbsent, problem::kPortGone};
  if (health && health->status == HealthStatus::kError) return {DeviceState::kFault, problem::kLidarErrorStays};
  if (health) return {DeviceState::kFault, problem::kLidarUnknown};
  return {DeviceState::kFault, dialogue_->receivedBytes() ? problem::kLidarUndecoded : problem::kLidarUnanswered, true};
}

void RplidarUnit::askRate() {
  sample_rate_ = {476, 500};  // of firmware that cannot be asked
  if (rplidar::comparableFirmware(info_) < rplidar::kFirmwareWithExpress) return;
  const auto rate = rplidar::parseSampleRate(ask(Request::kGetSampleRate, AnswerType::kSampleRate, 4));
  if (rate) sample_rate_ = *rate;
}

void RplidarUnit::askModes() {
  listed_modes_.clear();
  typical_mode_.reset();
  if (rplidar::comparableFirmware(info_) < rplidar::kFirmwareWithModes) return;
  std::vector<std::uint8_t> answer;
  const auto entry = [&](ConfigurationEntry which, std::optional<std::uint16_t> mode = {}) {
    answer =
        dialogue_->ask(rplidar::encodeConfigurationRequest(which, mode), AnswerType::kConfiguration, 0, kRplidarAnswer);
    return rplidar::parseConfiguration(which, answer).value_or(std::span<const std::uint8_t>{});
  };
  const std::uint16_t count = rplidar::parseModeNumber(entry(ConfigurationEntry::kModeCount)).value_or(0);
  if (count == 0) return;
  typical_mode_ = rplidar::parseModeNumber(entry(ConfigurationEntry::kTypicalMode));
  for (std::uint16_t id = 0; id < std::min(count, rplidar::kMostModes) && !dialogue_->cancelled(); ++id) {
    const auto sample_time = rplidar::parseSampleTime(entry(ConfigurationEntry::kSampleTime, id));
    if (answer.empty()) break;  // each further question would cost a timeout
    if (!sample_time) continue;
    const auto type = rplidar::parseAnswerType(entry(ConfigurationEntry::kAnswerType, id));
    if (!type) continue;
    listed_modes_.push_back(
        {.id = id,
         .by_express = true,
         .answer_type = *type,
         .sample_time = *sample_time,
         .max_distance = rplidar::parseMaxDistance(entry(ConfigurationEntry::kMaxDistance, id)).value_or(0.0),
         .name = rplidar::parseModeName(entry(ConfigurationEntry::kModeName, id))});
  }
}

void RplidarUnit::askMotor() {
  motor_by_pwm_ = false;
  motor_by_speed_ = info_.model >> 4 >= kFirstWithMotorSpeed;
  if (info_.model >> 4 < 2 || motor_by_speed_) return;
  const std::array<std::uint8_t, 4> zero{};
  const auto flags = dialogue_->ask(rplidar::encodeRequest(Request::kGetAccessoryBoardFlag, zero),
                                    AnswerType::kAccessoryBoardFlag, 4, kRplidarAnswer);
  motor_by_pwm_ = !flags.empty() && (flags[0] & 1) != 0;
}

RplidarUnit::Begun RplidarUnit::startScan() {
  setMotor(true);
  const auto modes = rplidar::modesToTry(config_.scan_mode, rplidar::comparableFirmware(info_), sample_rate_,
                                         listed_modes_, typical_mode_);
  for (std::size_t i = 0; i < modes.size() && !dialogue_->cancelled(); ++i) {
    if (auto start = startMode(modes[(passed_over_ + i) % modes.size()]))
      return {DeviceState::kStreaming, warning_, false, std::move(*start), identityOf(info_, mode_)};
    if (dialogue_->hungUp()) return {DeviceState::kAbsent, problem::kPortGone};
  }
  if (dialogue_->cancelled()) return {DeviceState::kAbsent, problem::kStoppedOpening};
  return {DeviceState::kFault, problem::kLidarNoScan};
}

std::optional<LidarScanStart> RplidarUnit::startMode(const rplidar::ScanMode& mode) {
  dialogue_->send(mode.by_express ? rplidar::encodeExpressScan(static_cast<std::uint8_t>(mode.id))
                                  : rplidar::encodeRequest(Request::kScan));
  const auto descriptor = dialogue_->awaitStream(kRplidarAnswer);
  const auto format = descriptor ? rplidar::packetFormat(descriptor->type) : std::nullopt;
  if (!format || format->size != descriptor->length) {
    dialogue_->send(rplidar::encodeRequest(Request::kStop));
    dialogue_->drain(kAfterStop, kRplidarAnswer);
    return std::nullopt;
  }
  mode_ = mode;
  mode_.answer_type = descriptor->type;  // whatever the mode list says
  RangeLimits limits = config_.limits;
  if (mode.max_distance > limits.min) limits.max = std::min(limits.max, static_cast<float>(mode.max_distance));
  if (const double longest = rplidar::longestRange(info_.model); longest > 0.0)
    limits.max = std::min(limits.max, static_cast<float>(longest));
  const double byte_time = 10.0 / config_.baud;                   // [s]
  const double packet_time = mode.sample_time * format->samples;  // [s]
  return LidarScanStart{.scans = std::make_unique<rplidar::ScanStream>(
                            rplidar::ScanStream::Format{.type = static_cast<AnswerType>(descriptor->type),
                                                        .sample_time = mode.sample_time,
                                                        .byte_time = byte_time,
                                                        .limits = limits}),
                        .read_ahead = dialogue_->takeInput(),
                        .busy_line = static_cast<double>(format->size) * byte_time > kBusyLine * packet_time};
}

}  // namespace slam
