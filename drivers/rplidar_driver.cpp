// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/rplidar_driver.hpp"

#include <algorithm>
#include <array>
#include <poll.h>

namespace slam {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;
using rplidar::Request;

constexpr Duration kAfterStop = 50ms;         // the unit needs 1 ms, its last packets a little more
constexpr Duration kAnswer = 500ms;           // to a request
constexpr Duration kBoot = 2s;                // after a reset
constexpr Duration kSpinUp = 3s;              // from the start of the scan to the first node
constexpr Duration kSilence = 500ms;          // while streaming
constexpr int kResets = 3;                    // then the unit is at fault
constexpr int kFirmwareWithExpress = 0x0111;  // 1.17
constexpr std::uint16_t kMotorPwm = 660;      // about 10 turns a second

}  // namespace

RplidarDriver::RplidarDriver(const RplidarConfig& config, Clock now, Sink sink)
    : config_(config),
      now_(now),
      sink_(std::move(sink)),
      byte_time_(10.0 / config.baud),
      assembler_({config.range_min, config.range_max}) {
  input_.reserve(4096);
  nodes_.reserve(2048);
}

bool RplidarDriver::fail(DeviceState state, const char* reason) {
  status_.set(state, reason);
  stop();
  return false;
}

bool RplidarDriver::connect(const std::atomic<bool>& cancel) {
  status_.set(DeviceState::kOpening, "opening");
  cancel_ = &cancel;
  const bool connected = openAndQuiet() && identify() && startScan();
  cancel_ = nullptr;
  return connected;
}

bool RplidarDriver::openAndQuiet() {
  OpenedPort port = openPort(config_.port, config_.baud);
  if (!port.stream) return fail(DeviceState::kAbsent, port.problem);
  stream_ = std::move(port.stream);
  hung_up_ = false;
  stream_->setDtr(true);  // motor off: a stale stream of an earlier run must not go on
  send(rplidar::encodeRequest(Request::kStop));
  drain(kAfterStop, 1s);
  return true;
}

bool RplidarDriver::identify() {
  for (int attempt = 0; attempt <= kResets && !cancelled(); ++attempt) {
    const auto health = rplidar::parseHealth(ask(Request::kGetHealth, AnswerType::kHealth, 3, kAnswer));
    const auto info =
        health ? rplidar::parseInfo(ask(Request::kGetInfo, AnswerType::kInfo, 20, kAnswer)) : std::nullopt;
    if (info && health->status != rplidar::HealthStatus::kError) {
      info_ = *info;
      sample_rate_ = {476, 500};  // of firmware before 1.17, which cannot be asked
      if (info_.firmware >= kFirmwareWithExpress) {
        const auto rate = rplidar::parseSampleRate(ask(Request::kGetSampleRate, AnswerType::kSampleRate, 4, kAnswer));
        if (rate) sample_rate_ = *rate;
      }
      const int major = info_.model >> 4;
      const std::array<std::uint8_t, 4> zero{};
      motor_by_pwm_ = false;
      if (major >= 2) {
        send(rplidar::encodeRequest(Request::kGetAccessoryBoardFlag, zero));
        motor_by_pwm_ =
            awaitDescriptor(AnswerType::kAccessoryBoardFlag, 4, kAnswer) && !input_.empty() && (input_[0] & 1);
        input_.clear();
      }
      return true;
    }
    if (hung_up_) return fail(DeviceState::kAbsent, "the port is gone: unplugged?");
    if (attempt == kResets) {
      const bool error = health && health->status == rplidar::HealthStatus::kError;
      return fail(DeviceState::kFault, error ? "the lidar reports a hardware error even after resets: see its manual"
                                             : "port present, but no answer: check baud rate and 5 V supply");
    }
    if (attempt > 0 || (health && health->status == rplidar::HealthStatus::kError)) {
      send(rplidar::encodeRequest(Request::kReset));
      if (!pause(kBoot / 2)) break;
    }
    drain(100ms, kBoot);
  }
  return fail(DeviceState::kAbsent, "stopped while opening");
}

bool RplidarDriver::startScan() {
  const bool automatic = config_.scan_mode == "auto";
  setMotor(true);
  const bool express = config_.scan_mode == "express" || (automatic && info_.firmware >= kFirmwareWithExpress);
  if (startScan(express) || (automatic && express && startScan(false))) return true;
  if (cancelled()) return fail(DeviceState::kAbsent, "stopped while opening");
  return fail(DeviceState::kFault, "the lidar does not start its scan: check its 5 V supply");
}

bool RplidarDriver::startScan(bool express) {
  const AnswerType type = express ? AnswerType::kExpressCapsules : AnswerType::kStandardNodes;
  const std::size_t packet = express ? rplidar::kExpressCapsuleSize : rplidar::kStandardNodeSize;
  const double sample_time = 1e-6 * (express ? sample_rate_.express_us : sample_rate_.standard_us);

  send(express ? rplidar::encodeExpressScan() : rplidar::encodeRequest(Request::kScan));
  if (!awaitDescriptor(type, packet, kAnswer)) {
    send(rplidar::encodeRequest(Request::kStop));
    drain(kAfterStop, kAnswer);
    return false;
  }
  decoder_ = std::make_unique<rplidar::StreamDecoder>(type, sample_time, byte_time_);
  assembler_.reset();
  sample_clock_ = SampleClock(sample_time);
  last_node_ = now_() + kSpinUp - kSilence;  // the motor may take that long
  status_.set(DeviceState::kOpening, "waiting for the motor's speed");
  return true;
}

bool RplidarDriver::poll(Duration timeout) {
  if (!stream_ || !decoder_) return false;
  std::array<std::uint8_t, 1024> chunk;
  std::size_t size = std::min(input_.size(), chunk.size());
  if (size > 0) {
    std::copy_n(input_.begin(), size, chunk.begin());
    input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(size));
  } else {
    const ReadResult result = stream_->read(chunk, timeout);
    if (result.status == ReadResult::kClosed) return fail(DeviceState::kAbsent, "the port is gone: unplugged?");
    size = result.size;
  }
  const Timestamp arrival = now_();  // of the chunk's last byte
  for (std::size_t i = 0; i < size; ++i) {
    nodes_.clear();
    decoder_->push(chunk[i], nodes_);
    const Timestamp byte_arrival = arrival - fromSeconds(byte_time_ * static_cast<double>(size - 1 - i));
    for (const rplidar::TimedNode& timed : nodes_) {
      last_node_ = arrival;
      const LaserScan* scan = assembler_.add(timed.node, sample_clock_.stamp(byte_arrival - fromSeconds(timed.age)));
      if (scan == nullptr) continue;
      status_.set(DeviceState::kStreaming, "");
      status_.countSample(arrival);
      sink_(*scan);
    }
  }
  const auto& counters = decoder_->counters();
  status_.rejects.store(counters.bad_check_bits + counters.bad_checksums + counters.encoder_resets,
                        std::memory_order_relaxed);
  if (arrival - last_node_ <= kSilence) return true;

  // Silent: the port is there, so ask the unit how it is before giving up.
  send(rplidar::encodeRequest(Request::kStop));
  drain(kAfterStop, 200ms);
  const auto health = rplidar::parseHealth(ask(Request::kGetHealth, AnswerType::kHealth, 3, 100ms));
  if (!health) return fail(DeviceState::kStale, "no data, port present, no answer: check 5 V supply and cable");
  return fail(DeviceState::kStale, health->status == rplidar::HealthStatus::kError
                                       ? "no data, port present, the lidar reports a hardware error"
                                       : "no data, port present, health OK: check 5 V supply and motor");
}

void RplidarDriver::stop() {
  if (!stream_) return;
  send(rplidar::encodeRequest(Request::kStop));
  ::poll(nullptr, 0, 5);  // a request right behind STOP is lost
  setMotor(false);
  stream_.reset();
  decoder_.reset();
  input_.clear();
}

void RplidarDriver::setMotor(bool on) {
  if (motor_by_pwm_) send(rplidar::encodeMotorPwm(on ? kMotorPwm : 0));
  stream_->setDtr(!on);  // the A1's adapter inverts it
}

void RplidarDriver::drain(Duration silence, Duration limit) {
  std::array<std::uint8_t, 1024> chunk;
  const Timestamp end = now_() + limit;
  while (now_() < end && !cancelled() && stream_->read(chunk, silence).status == ReadResult::kData) {
  }
  input_.clear();
}

bool RplidarDriver::pause(Duration time) {
  for (const Timestamp end = now_() + time; now_() < end && !cancelled();) ::poll(nullptr, 0, 20);
  return !cancelled();
}

bool RplidarDriver::awaitDescriptor(AnswerType type, std::size_t size, Duration timeout) {
  // Bytes of an old stream may precede the answer: search for it.
  const Timestamp end = now_() + timeout;
  std::array<std::uint8_t, 1024> chunk;
  for (;;) {
    for (std::size_t at = 0; at + rplidar::kDescriptorSize <= input_.size(); ++at) {
      const auto found = rplidar::parseDescriptor({input_.data() + at, rplidar::kDescriptorSize});
      if (!found || found->type != static_cast<std::uint8_t>(type) || found->length != size) continue;
      input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(at + rplidar::kDescriptorSize));
      return true;
    }
    const Duration left = end - now_();
    if (left <= 0ns || cancelled()) return false;
    const ReadResult result = stream_->read(chunk, left);
    if (result.status == ReadResult::kClosed) {
      hung_up_ = true;
      return false;
    }
    input_.insert(input_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(result.size));
    if (input_.size() > 8192) input_.erase(input_.begin(), input_.end() - rplidar::kDescriptorSize);
  }
}

std::vector<std::uint8_t> RplidarDriver::ask(Request request, AnswerType type, std::size_t size, Duration timeout) {
  const Timestamp end = now_() + timeout;
  input_.clear();
  if (!send(rplidar::encodeRequest(request)) || !awaitDescriptor(type, size, timeout)) return {};
  std::array<std::uint8_t, 64> chunk;
  while (input_.size() < size) {
    const Duration left = end - now_();
    if (left <= 0ns) return {};
    const ReadResult result = stream_->read(chunk, left);
    if (result.status == ReadResult::kClosed) return {};
    input_.insert(input_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(result.size));
  }
  std::vector<std::uint8_t> answer(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(size));
  input_.clear();
  return answer;
}

}  // namespace slam
