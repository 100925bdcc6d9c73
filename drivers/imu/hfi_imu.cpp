// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/hfi_imu.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "drivers/companion.hpp"
#include "drivers/imu/codec/witmotion_frames.hpp"
#include "drivers/imu/imu_protocols.hpp"
#include "problems/devices.hpp"
#include "timing/stream_clock.hpp"

namespace slam {
namespace {

constexpr std::uint32_t kRecognisedFraming = 3;  // good frames of a framing
Eigen::Vector3d vector(const std::array<float, 3>& values) {
  return {static_cast<double>(values[0]), static_cast<double>(values[1]), static_cast<double>(values[2])};
}

/// The unit gives acceleration in g with the sign of gravity; that is turned to specific force. (The vendor's own
/// driver uses the gyro as it comes and multiplies acceleration by -9.8.)
class HfiProtocol : public ImuProtocol {
 public:
  void begin(int) override {
    a9_.reset();
    b6_.reset();
    framing_ = Framing::kUnknown;
    a9_frames_ = b6_frames_ = 0;
    gravity_.reset();
    with_gravity_ = {};
    clock_ = StreamClock();
    ignored_ = damage_ = 0;
  }

  /// Both decoders listen until one of them has understood; a checksum may be right by chance, but not three in a row.
  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    if (framing_ != Framing::kB6) {
      a9_.push(byte, [&](std::span<const std::uint8_t> frame) { handleA9(frame, now, take); });
      if (framing_ == Framing::kUnknown && a9_frames_ >= kRecognisedFraming) recognise(Framing::kA9);
    }
    if (framing_ != Framing::kA9) {
      b6_.push(byte, [&](std::span<const std::uint8_t> frame) { handleB6(witmotion::parse(frame), now, take); });
      if (framing_ == Framing::kUnknown && b6_frames_ >= kRecognisedFraming) recognise(Framing::kB6);
    }
  }

  std::uint32_t frames() const override {
    return framing_ == Framing::kA9 ? a9_frames_ : framing_ == Framing::kB6 ? b6_frames_ : 0;
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

  void recognise(Framing framing) {
    framing_ = framing;
    ignored_ = raw();  // what the decoder met before is counted, or was not meant for it
  }
  std::uint32_t raw() const {
    // Bytes outside of frames count as so many of the smallest frames.
    const auto damageOf = [](const auto& decoder) {
      return decoder.damaged() + decoder.skipped() / static_cast<std::uint32_t>(witmotion::kFrameSize);
    };
    return not_finite_ + (framing_ == Framing::kA9 ? damageOf(a9_) : damageOf(b6_));
  }

  void handleA9(std::span<const std::uint8_t> frame, Timestamp now, const Take& take) {
    ++a9_frames_;
    if (framing_ != Framing::kA9 || frame.size() != hfi::kA9MaxFrame) return;  // attitude is not used
    const auto motion = hfi::parseA9Motion(frame);
    if (!motion) {
      ++not_finite_;
      return;
    }
    emit(vector(motion->gyro), vector(motion->accel), now, take);
  }

  void handleB6(const witmotion::Frame& frame, Timestamp now, const Take& take) {
    ++b6_frames_;
    if (framing_ != Framing::kB6) return;
    if (frame.type == witmotion::Type::kAcceleration) {
      gravity_ = frame.scaled(witmotion::kGravitiesPerCount);
    } else if (frame.type == witmotion::Type::kTurnRate) {
      // A set begins with acceleration: without it the gyro's would be paired with that of the set before.
      with_gravity_.note(gravity_.has_value());
      if (gravity_ || !with_gravity_.expected())
        emit(frame.scaled(witmotion::kRadiansPerSecondPerCount), gravity_.value_or(Eigen::Vector3d::Zero()), now, take);
      gravity_.reset();
    }
  }

  /// @param gravity [g]; zero: not measured
  void emit(const Eigen::Vector3d& gyro, const Eigen::Vector3d& gravity, Timestamp now, const Take& take) {
    const bool lost = std::exchange(damage_, damage()) != damage();
    take({clock_.stamp(now, lost), gyro, -kStandardGravity * gravity});
  }

  hfi::A9Decoder a9_;
  witmotion::Decoder b6_;
  Framing framing_ = Framing::kUnknown;
  std::uint32_t a9_frames_ = 0, b6_frames_ = 0;  // since the opening
  std::optional<Eigen::Vector3d> gravity_;       // [g] of a B6's set under way
  Companion with_gravity_;                       // the gyro's frames of a B6
  StreamClock clock_;
  std::uint32_t not_finite_ = 0, ignored_ = 0, damage_ = 0;
};

}  // namespace

std::unique_ptr<ImuProtocol> makeHfiProtocol() { return std::make_unique<HfiProtocol>(); }

}  // namespace slam
