// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/hfi_imu.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "drivers/companion.hpp"
#include "firmware_if/hfi_imu.hpp"
#include "problems/devices.hpp"
#include "timing/stream_clock.hpp"

namespace slam {
namespace {

constexpr std::uint32_t kRecognised = 3;      // good frames of a framing
constexpr double kStandardGravity = 9.80665;  // [m/s^2] of one g

Eigen::Vector3d vector(const std::array<float, 3>& values) {
  return {static_cast<double>(values[0]), static_cast<double>(values[1]), static_cast<double>(values[2])};
}

Eigen::Vector3d scaled(const hfi::B6Frame& frame, float unit) {
  return static_cast<double>(unit) * Eigen::Vector3d(frame.raw[0], frame.raw[1], frame.raw[2]);
}

/// The unit gives acceleration in g with the sign of gravity; that is turned to specific force. (The vendor's own
/// driver uses the gyro as it comes and multiplies acceleration by -9.8.)
class HfiProtocol : public ImuProtocol {
 public:
  void begin(int) override {
    a9_.reset();
    b6_.reset();
    framing_ = Framing::kUnknown;
    a9_begin_ = a9_.counters().frames;
    b6_begin_ = b6_.counters().frames;
    gravity_.reset();
    with_gravity_ = {};
    clock_ = StreamClock();
    ignored_ = damage_ = 0;
  }

  /// Both decoders listen until one of them has understood; a checksum may be right by chance, but not three in a row.
  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    if (framing_ != Framing::kB6) {
      for (auto data = a9_.push(byte); data; data = a9_.flush()) handle(*data, now, take);
      if (framing_ == Framing::kUnknown && a9Frames() >= kRecognised) recognise(Framing::kA9);
    }
    if (framing_ != Framing::kA9) {
      for (auto frame = b6_.push(byte); frame; frame = b6_.flush()) handle(*frame, now, take);
      if (framing_ == Framing::kUnknown && b6Frames() >= kRecognised) recognise(Framing::kB6);
    }
  }

  std::uint32_t frames() const override {
    return framing_ == Framing::kA9 ? a9Frames() : framing_ == Framing::kB6 ? b6Frames() : 0;
  }
  std::uint32_t damage() const override { return framing_ == Framing::kUnknown ? 0 : raw() - ignored_; }
  Problem finding() const override {
    const bool bare = framing_ == Framing::kB6 && !with_gravity_.expected();
    return bare ? Problem(problem::kImuNoAcceleration) : Problem();
  }
  const char* identity() const override {
    return framing_ == Framing::kA9 ? "HandsFree A9" : framing_ == Framing::kB6 ? "HandsFree B6, B9 or D6" : "";
  }

 private:
  enum class Framing : std::uint8_t { kUnknown, kA9, kB6 };

  std::uint32_t a9Frames() const { return a9_.counters().frames - a9_begin_; }
  std::uint32_t b6Frames() const { return b6_.counters().frames - b6_begin_; }
  void recognise(Framing framing) {
    framing_ = framing;
    ignored_ = raw();  // what the decoder met before is counted, or was not meant for it
  }
  std::uint32_t raw() const {
    const hfi::DecoderCounters& counters = framing_ == Framing::kA9 ? a9_.counters() : b6_.counters();
    // Bytes outside of frames count as so many of the smallest frames.
    return not_finite_ + counters.bad_checksums + counters.skipped_bytes / static_cast<std::uint32_t>(hfi::kB6Frame);
  }

  void handle(hfi::A9Decoder::Data data, Timestamp now, const Take& take) {
    if (framing_ != Framing::kA9 || data.size() != hfi::kA9MotionLength) return;  // attitude is not used
    const auto motion = hfi::parseA9Motion(data);
    if (!motion) {
      ++not_finite_;
      return;
    }
    emit(vector(motion->gyro), vector(motion->accel), now, take);
  }

  void handle(const hfi::B6Frame& frame, Timestamp now, const Take& take) {
    if (framing_ != Framing::kB6) return;
    if (frame.type == hfi::B6Type::kAccel) {
      gravity_ = scaled(frame, hfi::kB6Accel);
    } else if (frame.type == hfi::B6Type::kGyro) {
      // A set begins with acceleration: without it the gyro's would be paired with that of the set before.
      with_gravity_.note(gravity_.has_value());
      if (gravity_ || !with_gravity_.expected())
        emit(scaled(frame, hfi::kB6Gyro), gravity_.value_or(Eigen::Vector3d::Zero()), now, take);
      gravity_.reset();
    }
  }

  /// @param gravity [g]; zero: not measured
  void emit(const Eigen::Vector3d& gyro, const Eigen::Vector3d& gravity, Timestamp now, const Take& take) {
    const bool lost = std::exchange(damage_, damage()) != damage();
    take({clock_.stamp(now, lost), gyro, -kStandardGravity * gravity});
  }

  hfi::A9Decoder a9_;
  hfi::B6Decoder b6_;
  Framing framing_ = Framing::kUnknown;
  std::uint32_t a9_begin_ = 0, b6_begin_ = 0;  // frames before this opening
  std::optional<Eigen::Vector3d> gravity_;     // [g] of a B6's set under way
  Companion with_gravity_;                     // the gyro's frames of a B6
  StreamClock clock_;
  std::uint32_t not_finite_ = 0, ignored_ = 0, damage_ = 0;
};

}  // namespace

std::unique_ptr<ImuProtocol> makeHfiProtocol() { return std::make_unique<HfiProtocol>(); }

}  // namespace slam
