// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/handsfree_board.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

using namespace std::chrono_literals;
using robolink::Command;

constexpr Duration kAnswer = 100ms;  // a request not answered by then is lost
constexpr Duration kStale = 500ms;   // no answer at all
constexpr Duration kDead = 3s;       // then the port is opened anew
constexpr Duration kRefresh = 60ms;  // the board renews its values every 20 to 50 ms
constexpr Duration kFirstBackOff = 200ms, kLongestBackOff = 1s;
constexpr float kImpossibleTurn = 20.0F;  // [rad] of a wheel between two readings: the counter started anew

}  // namespace

HandsfreeBoard::HandsfreeBoard(const HandsfreeConfig& config, Clock now, Sinks sinks)
    : config_(config),
      now_(now),
      sinks_(std::move(sinks)),
      polls_{Poll{Command::kGetMotorMileage, fromSeconds(1.0 / config.mileage_rate), {}},
             Poll{Command::kGetImu, fromSeconds(1.0 / config.imu_rate), {}}, Poll{Command::kGetSystemInfo, 1s, {}}} {}

void HandsfreeBoard::tick() {
  const Timestamp now = now_();
  if (!stream_) {
    if (now >= next_open_) open(now);
    return;
  }
  if (!receive()) return close(now, DeviceState::kAbsent, "the port is gone: unplugged?");
  watch(now);
  if (stream_) request(now);
}

void HandsfreeBoard::open(Timestamp now) {
  OpenedPort port = openPort(config_.port, config_.baud);
  if (!port.stream) return close(now, DeviceState::kAbsent, port.problem);
  stream_ = std::move(port.stream);
  stream_->discardInput();
  decoder_.reset();
  pending_.reset();
  restarted_ = true;
  mileage_.reset();
  answered_ = now;
  setBoth(DeviceState::kOpening, "waiting for the board's first answer");
}

void HandsfreeBoard::close(Timestamp now, DeviceState state, const char* reason) {
  stream_.reset();
  back_off_ = std::clamp(2 * back_off_, kFirstBackOff, kLongestBackOff);
  next_open_ = now + back_off_;
  setBoth(state, reason);
}

void HandsfreeBoard::setBoth(DeviceState state, const char* reason) {
  wheels_.set(state, reason);
  imu_.set(state, reason);
}

bool HandsfreeBoard::receive() {
  std::array<std::uint8_t, 512> chunk;
  for (;;) {
    const ReadResult result = stream_->read(chunk, 0ns);
    if (result.status == ReadResult::kClosed) return false;
    if (result.status == ReadResult::kTimeout) break;
    for (std::size_t i = 0; i < result.size; ++i) {
      for (auto frame = decoder_.push(chunk[i]); frame; frame = decoder_.flush()) handle(*frame);
    }
  }
  const auto& counters = decoder_.counters();
  const auto damaged = counters.bad_checksums + counters.bad_lengths + counters.foreign_frames;
  wheels_.rejects.store(damaged + unanswered_, std::memory_order_relaxed);
  return true;
}

void HandsfreeBoard::handle(const robolink::Frame& frame) {
  answered_ = now_();
  back_off_ = 0ns;
  if (frame.command == static_cast<std::uint8_t>(Command::kShakingHands)) {
    // The board has just started. It wants the last coordinate; its own odometry is not used here, so that is zero.
    send(Command::kShakingHands, robolink::encodeCoordinate({}));
    restarted_ = true;
    pending_.reset();
    return;
  }
  if (!pending_ || frame.command != static_cast<std::uint8_t>(*pending_)) return;  // an answer that came too late
  pending_.reset();
  if (frame.command == static_cast<std::uint8_t>(Command::kGetMotorMileage)) {
    if (const auto mileage = robolink::parseMotorVector(frame.payload)) return handleMileage(*mileage);
  } else if (frame.command == static_cast<std::uint8_t>(Command::kGetImu)) {
    if (const auto imu = robolink::parseImu(frame.payload)) return handleImu(*imu);
  } else if (frame.command == static_cast<std::uint8_t>(Command::kGetSystemInfo)) {
    if (const auto info = robolink::parseSystemInfo(frame.payload)) {
      battery_ = info->battery;
      return;
    }
  }
  imu_.rejects.fetch_add(1, std::memory_order_relaxed);
}

void HandsfreeBoard::handleMileage(const robolink::MotorVector& mileage) {
  // The same value again is stale while the wheels turn: leave it out, the next difference spans it.
  const bool same = mileage_ && mileage == *mileage_;
  if (same && requested_ - mileage_changed_ < kRefresh) return;
  if (!same) mileage_changed_ = requested_;
  const bool jumped = mileage_ && (std::abs(mileage[0] - (*mileage_)[0]) > kImpossibleTurn ||
                                   std::abs(mileage[1] - (*mileage_)[1]) > kImpossibleTurn);
  mileage_ = mileage;
  // The left motor counts negative when the base drives forward.
  const Timestamp stamp = requested_ - fromSeconds(config_.sample_age);
  sinks_.wheels({stamp, -static_cast<double>(mileage[0]), static_cast<double>(mileage[1]), restarted_ || jumped});
  restarted_ = false;
  wheels_.countSample(requested_);
  wheels_.set(DeviceState::kStreaming, "");
}

void HandsfreeBoard::handleImu(const robolink::Imu& imu) {
  if ((imu.online & 1) == 0) {
    imu_.set(DeviceState::kFault, "the board says that its IMU is offline");
    return;
  }
  if (last_imu_ && last_imu_->gyro == imu.gyro && last_imu_->accel == imu.accel) return;  // not renewed yet
  last_imu_ = imu;
  ImuSample sample;
  sample.stamp = requested_ - fromSeconds(config_.sample_age);
  for (int i = 0; i < 3; ++i) {
    sample.gyro[i] = static_cast<double>(imu.gyro[static_cast<std::size_t>(i)]);
    sample.accel[i] = static_cast<double>(imu.accel[static_cast<std::size_t>(i)]);
  }
  sinks_.imu(sample);
  imu_.countSample(requested_);
  imu_.set(DeviceState::kStreaming, "");
}

void HandsfreeBoard::watch(Timestamp now) {
  const auto silent = [&](const DeviceStatus& status) {
    const std::int64_t last = status.last_sample_ns.load(std::memory_order_relaxed);
    return status.state == DeviceState::kStreaming && now.time_since_epoch().count() - last > kStale.count();
  };
  if (now - answered_ > kDead)
    return close(now, DeviceState::kFault, "port present, but the board never answers: check baud rate and power");
  if (now - answered_ > kStale) return setBoth(DeviceState::kStale, "the board does not answer: check its power");
  if (silent(imu_)) imu_.set(DeviceState::kStale, "the board answers, but its IMU values never change");
  if (silent(wheels_)) wheels_.set(DeviceState::kStale, "the board answers, but not with mileage");
}

void HandsfreeBoard::request(Timestamp now) {
  if (pending_) {
    if (now - requested_ < kAnswer) return;
    pending_.reset();
    decoder_.reset();  // half a frame must not hold the next answer back
    ++unanswered_;
  }
  const auto next =
      std::min_element(polls_.begin(), polls_.end(), [](const Poll& a, const Poll& b) { return a.due < b.due; });
  if (next->due > now) return;
  next->due = std::max(next->due + next->period, now);
  send(next->command);
  pending_ = next->command;
  requested_ = now;
}

void HandsfreeBoard::send(Command command, std::span<const std::uint8_t> payload) {
  std::array<std::uint8_t, robolink::kMaxFrame> frame;
  const std::size_t size = robolink::encodeFrame(robolink::kMaster, robolink::kSlave, command, payload, frame);
  stream_->write({frame.data(), size});
}

}  // namespace slam
