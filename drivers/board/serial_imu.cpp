// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board/serial_imu.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kStale = 500ms;            // nothing that can be used
constexpr Duration kDead = 3s;                // then the port is opened anew
constexpr std::uint32_t kRecognised = 3;      // good frames of a framing
constexpr double kStandardGravity = 9.80665;  // [m/s^2] of one g

Eigen::Vector3d vector(const std::array<float, 3>& values) {
  return {static_cast<double>(values[0]), static_cast<double>(values[1]), static_cast<double>(values[2])};
}

Eigen::Vector3d scaled(const hfi::B6Frame& frame, float unit) {
  return static_cast<double>(unit) * Eigen::Vector3d(frame.raw[0], frame.raw[1], frame.raw[2]);
}

}  // namespace

SerialImu::SerialImu(const SerialImuConfig& config, Clock now, Sink sink)
    : now_(now),
      sink_(std::move(sink)),
      port_(config.port, config.baud, config.in_background),
      wrong_speaker_(PortOf::kImu, config.port, config.baud) {}

void SerialImu::tick() {
  const Timestamp now = now_();
  if (!port_.isOpen()) {
    if (wrong_speaker_.running()) {
      if (port_.isReleased() && !wrong_speaker_.tick(now))
        status_.set(DeviceState::kFault, wrong_speaker_.found(status_.problem()));
    } else if (port_.due(now)) {
      open(now);
    }
    return;
  }
  if (!receive(now)) return close(now, DeviceState::kAbsent, problem::kPortGone);
  watch(now);
}

void SerialImu::open(Timestamp now) {
  if (const Problem problem = port_.open(now)) {
    wrong_speaker_.forget();
    return status_.set(DeviceState::kAbsent, problem);
  }
  with_gravity_ = {};
  a9_.reset();
  b6_.reset();
  framing_ = Framing::kUnknown;
  a9_begin_ = a9_.counters().frames;
  b6_begin_ = b6_.counters().frames;
  b6_gravity_.reset();
  clock_ = StreamClock();
  bytes_came_ = sampled_ = false;
  opened_ = frame_ = changed_ = now;
  status_.setOpening(Problem(problem::kWaitsForFrames, {}, {"the IMU's"}));
}

void SerialImu::close(Timestamp now, DeviceState state, const Problem& why) {
  port_.fail(now);
  if (state == DeviceState::kAbsent) wrong_speaker_.forget();
  status_.set(state, why);
}

bool SerialImu::receive(Timestamp now) {
  const bool open = port_.drain([&](std::uint8_t byte) {
    bytes_came_ = true;
    take(byte, now);
  });
  countRejects();
  return open;
}

/// Both decoders listen until one of them has understood; a checksum may be right by chance, but not three in a row.
void SerialImu::take(std::uint8_t byte, Timestamp now) {
  if (framing_ != Framing::kB6) {
    for (auto data = a9_.push(byte); data; data = a9_.flush()) take(*data, now);
    if (framing_ == Framing::kUnknown && a9_.counters().frames - a9_begin_ >= kRecognised) recognise(Framing::kA9);
  }
  if (framing_ != Framing::kA9) {
    for (auto frame = b6_.push(byte); frame; frame = b6_.flush()) take(*frame, now);
    if (framing_ == Framing::kUnknown && b6_.counters().frames - b6_begin_ >= kRecognised) recognise(Framing::kB6);
  }
}

void SerialImu::recognise(Framing framing) {
  framing_ = framing;
  damage_ = damage();  // what the decoder met before is counted, or was not meant for it
}

void SerialImu::take(hfi::A9Decoder::Data data, Timestamp now) {
  if (framing_ != Framing::kA9) return;
  frame_ = now;
  bytes_came_ = false;
  if (data.size() != hfi::kA9MotionLength) return;  // attitude is not used
  const auto motion = hfi::parseA9Motion(data);
  if (!motion) {
    ++not_finite_;
    return;
  }
  emit(vector(motion->gyro), vector(motion->accel), now);
}

void SerialImu::take(const hfi::B6Frame& frame, Timestamp now) {
  if (framing_ != Framing::kB6) return;
  frame_ = now;
  bytes_came_ = false;
  if (frame.type == hfi::B6Type::kAccel) {
    b6_gravity_ = scaled(frame, hfi::kB6Accel);
  } else if (frame.type == hfi::B6Type::kGyro) {
    // A set begins with acceleration: without it the gyro's would be paired with that of the set before.
    with_gravity_.note(b6_gravity_.has_value());
    if (b6_gravity_ || !with_gravity_.expected())
      emit(scaled(frame, hfi::kB6Gyro), b6_gravity_.value_or(Eigen::Vector3d::Zero()), now);
    b6_gravity_.reset();
  }
}

void SerialImu::emit(const Eigen::Vector3d& gyro, const Eigen::Vector3d& gravity, Timestamp now) {
  countRejects();
  const Timestamp stamp = clock_.stamp(now, lost_);
  lost_ = false;
  if (!sampled_ || gyro != last_gyro_ || gravity != last_gravity_) changed_ = now;
  sampled_ = true;
  last_gyro_ = gyro;
  last_gravity_ = gravity;
  if (now - changed_ > kStale) {  // a real sensor never repeats itself for long
    status_.set(DeviceState::kStale, problem::kImuFrozen);
    return;
  }
  sink_({stamp, gyro, -kStandardGravity * gravity});
  status_.countSample(now);
  const bool bare = framing_ == Framing::kB6 && !with_gravity_.expected();
  status_.set(DeviceState::kStreaming, bare ? problem::kImuNoAcceleration : Problem());
  port_.succeeded();
  wrong_speaker_.forget();
}

std::uint32_t SerialImu::damage() const {
  std::uint32_t damage = not_finite_;
  // Bytes outside of frames count as so many of the smallest frames.
  const auto countOf = [](const hfi::DecoderCounters& counters) {
    return counters.bad_checksums + counters.skipped_bytes / static_cast<std::uint32_t>(hfi::kB6Frame);
  };
  if (framing_ == Framing::kA9) damage += countOf(a9_.counters());
  if (framing_ == Framing::kB6) damage += countOf(b6_.counters());
  return damage;
}

void SerialImu::countRejects() {
  const std::uint32_t now = damage();
  lost_ = lost_ || now != damage_;
  if (now > damage_) status_.rejects.fetch_add(now - damage_, std::memory_order_relaxed);
  damage_ = now;
}

void SerialImu::watch(Timestamp now) {
  const Timestamp last = std::max(opened_, frame_);
  if (now - last > kDead) {
    const Problem unknown = bytes_came_ ? problem::kImuUndecoded : problem::kImuUnanswered;
    close(now, DeviceState::kFault, wrong_speaker_.found(unknown));
    return wrong_speaker_.ask();
  }
  if (now - last > kStale) {
    status_.set(DeviceState::kStale, wrong_speaker_.found(bytes_came_ ? problem::kImuGarbage : problem::kImuSilent));
  }
}

}  // namespace slam
