// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/rplidar_driver.hpp"

#include <algorithm>
#include <array>

namespace slam {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;
using rplidar::HealthStatus;
using rplidar::Request;

constexpr Duration kHoldUp = 100ms;  // between two reads: what comes then has lost its time
// Between two reads, so that not every two bytes wake the thread. On a busy line it costs the stamps nothing: the last
// of the bytes that wait has just come, and those before it came one behind the other.
constexpr Duration kRest = 3ms;
constexpr Duration kSlowestTurn = 2s;      // ten times what these units need
constexpr Duration kLastQuestion = 250ms;  // to a silent unit; a boot is over by then

/// @param stride one of so many measurements is used
Problem thinning(int stride) {
  if (stride < 2) return {};
  return stride == 2 ? problem::kLidarHalved : problem::kLidarThinned;
}

}  // namespace

RplidarDriver::RplidarDriver(const RplidarConfig& config, Clock now, Sink sink, PortOpener open)
    : config_(config),
      now_(now),
      sink_(std::move(sink)),
      open_(std::move(open)),
      wrong_speaker_(PortOf::kLidar, config.port, config.baud, open_),
      byte_time_(10.0 / config.baud) {
  report_scan_ = [this](const LaserScan& scan) {
    status_.set(DeviceState::kStreaming, warning_ ? warning_ : thinning(scans_->stride()));
    status_.thinned.store(thinned_before_ + scans_->thinned(), std::memory_order_relaxed);
    status_.countSample(last_arrival_);
    sink_(scan);
  };
}

bool RplidarDriver::fail(DeviceState state, const Problem& why) {
  status_.set(state, why);
  stop();
  return false;
}

bool RplidarDriver::lose(DeviceState state, const Problem& why) {
  lost_();
  return fail(state, why);
}

bool RplidarDriver::connect(const std::atomic<bool>& cancel) {
  status_.setOpening(problem::kOpening);
  stop();
  OpenedPort port = open_(config_.port, config_.baud);
  if (!port.stream) {
    wrong_speaker_.forget();
    return fail(DeviceState::kAbsent, port.problem);
  }
  stream_ = std::move(port.stream);
  dialogue_ = std::make_unique<rplidar::Dialogue>(*stream_, now_, &cancel);
  quiet();
  unanswered_ = {};
  const bool connected = identify() && startScan();
  if (connected) {
    dialogue_ = std::make_unique<rplidar::Dialogue>(*stream_, now_, nullptr);  // `cancel` may not live longer
    return true;
  }
  if (unanswered_) findSpeaker(cancel);
  return false;
}

bool RplidarDriver::poll(Duration timeout) {
  if (!stream_ || !scans_) return false;
  std::array<std::uint8_t, 1024> chunk;
  std::size_t size = std::min(read_ahead_.size(), chunk.size());
  if (size > 0) {
    std::copy_n(read_ahead_.begin(), size, chunk.begin());
    read_ahead_.erase(read_ahead_.begin(), read_ahead_.begin() + static_cast<std::ptrdiff_t>(size));
  } else {
    if (rests_ && timeout > kRest) stream_->rest(kRest);
    const Duration patience = std::max<Duration>(last_node_ + kSilence - now_(), 0ns);
    const ReadResult result = stream_->read(chunk, std::min(timeout, patience));
    if (result.status == ReadResult::kClosed) return lose(DeviceState::kAbsent, problem::kPortGone);
    size = result.size;
  }
  const Timestamp arrival = now_();  // of the chunk's last byte
  if (size > 0) {
    const bool held_up = bytes_ > 0 && arrival - last_arrival_ > kHoldUp;
    last_arrival_ = arrival;
    bytes_ += static_cast<std::int64_t>(size);
    int nodes = 0;
    if (held_up) {
      scans_->restart();
      catching_up_ = true;
    }
    if (catching_up_) {
      scans_->skip({chunk.data(), size});
      last_node_ = last_turn_ = arrival;  // late is not silent
      catching_up_ = size == chunk.size();
    } else {
      nodes = scans_->push({chunk.data(), size}, arrival, report_scan_);
    }
    if (scans_->sawBootText()) return lose(DeviceState::kStale, problem::kLidarRestarted);
    status_.rejects.store(rejects_before_ + scans_->rejects(), std::memory_order_relaxed);
    if (nodes > 0) last_node_ = arrival;
    nodes_ += nodes;
    if (scans_->turns() != turns_) last_turn_ = arrival;
    turns_ = scans_->turns();
  }
  if (nodes_ > 0 && arrival - last_turn_ > kSlowestTurn) return lose(DeviceState::kStale, problem::kLidarHeadStands);
  if (arrival - last_node_ < kSilence) return true;
  lost_();
  return endSilence();
}

/// The port is there, so ask the unit how it is before giving up.
bool RplidarDriver::endSilence() {
  const bool undecodable = nodes_ == 0 && bytes_ > 0;
  if (undecodable) ++passed_over_;
  dialogue_->send(rplidar::encodeRequest(Request::kStop));
  dialogue_->drain(kAfterStop, 2 * kAfterStop);
  const auto health = askHealth(kLastQuestion);
  if (dialogue_->hungUp()) return fail(DeviceState::kAbsent, problem::kPortGone);
  if (dialogue_->sawBoot()) return fail(DeviceState::kStale, problem::kLidarRestarted);
  if (!health) return fail(DeviceState::kStale, problem::kLidarSilent);
  if (health->status == HealthStatus::kError) return fail(DeviceState::kStale, problem::kLidarError);
  if (undecodable) return fail(DeviceState::kStale, problem::kLidarGarbage);
  if (nodes_ == 0) return fail(DeviceState::kStale, problem::kLidarMotorStands);
  return fail(DeviceState::kStale, problem::kLidarIdle);
}

void RplidarDriver::stop() {
  if (!stream_) return;
  stream_->write(rplidar::encodeRequest(Request::kStop));
  stream_->rest(5ms);  // a request right behind STOP is lost
  setMotor(false);
  if (scans_) rejects_before_ += scans_->rejects(), thinned_before_ += scans_->thinned();
  scans_.reset();
  dialogue_.reset();
  stream_.reset();
  read_ahead_.clear();
}

void RplidarDriver::setMotor(bool on) {
  constexpr std::uint16_t kMotorPwm = 660;    // about 10 turns a second
  constexpr std::uint16_t kMotorSpeed = 600;  // [rpm] ten turns a second
  if (motor_by_pwm_) stream_->write(rplidar::encodeMotorPwm(on ? kMotorPwm : 0));
  if (motor_by_speed_) stream_->write(rplidar::encodeMotorSpeed(on ? kMotorSpeed : 0));
  stream_->setDtr(!on);  // the A1's adapter inverts it
}

}  // namespace slam
