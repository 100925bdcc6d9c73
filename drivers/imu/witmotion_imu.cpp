// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "drivers/companion.hpp"
#include "drivers/imu/codec/witmotion_frames.hpp"
#include "drivers/imu/imu_protocols.hpp"
#include "problems/devices.hpp"
#include "timing/stream_clock.hpp"

namespace slam {
namespace {

using witmotion::Frame;
using witmotion::Type;

bool isAtTheEndOfItsRange(const Frame& frame) {
  const auto [least, most] = std::minmax({frame.raw[0], frame.raw[1], frame.raw[2]});
  return least == std::numeric_limits<std::int16_t>::min() || most == std::numeric_limits<std::int16_t>::max();
}

/// A set of frames is sent at once, acceleration first, so its stamp is that of its first byte. At 9600 bit/s the turn
/// rate's last byte comes 23 ms later.
class WitmotionProtocol : public ImuProtocol {
 public:
  void begin(int baud) override {
    frames_.reset();
    clock_ = StreamClock();
    set_.reset();
    with_acceleration_ = {};
    damage_ = damage();
    transfer_ = transferTime(witmotion::kFrameSize, baud);
  }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    frames_.push(byte, [&](std::span<const std::uint8_t> frame) { handle(witmotion::parse(frame), now, take); });
  }

  std::uint32_t frames() const override { return good_; }
  std::uint32_t damage() const override {
    return frames_.damaged() + frames_.skipped() / static_cast<std::uint32_t>(witmotion::kFrameSize);
  }
  Problem finding() const override {
    return with_acceleration_.expected() ? Problem() : Problem(problem::kImuNoAcceleration);
  }

 private:
  struct Set {
    Timestamp begin;               // of its transfer
    Eigen::Vector3d acceleration;  // [m/s^2] specific force
  };

  void handle(const Frame& frame, Timestamp now, const Take& take) {
    ++good_;
    const Timestamp begin = now - transfer_;
    if (frame.type == Type::kAcceleration)
      set_ = Set{begin, frame.scaled(kStandardGravity * witmotion::kGravitiesPerCount)};
    if (frame.type != Type::kTurnRate) return;
    // Without its acceleration the turn rate would be paired with that of the set before.
    with_acceleration_.note(set_.has_value());
    if (set_ || !with_acceleration_.expected()) {
      const bool lost = std::exchange(damage_, damage()) != damage();
      const Timestamp stamp = clock_.stamp(set_ ? set_->begin : begin, lost);
      take({.stamp = stamp,
            .gyro = frame.scaled(witmotion::kRadiansPerSecondPerCount),
            .accel = set_ ? set_->acceleration : Eigen::Vector3d::Zero(),
            .rate_known = !isAtTheEndOfItsRange(frame)});
    }
    set_.reset();
  }

  witmotion::Decoder frames_;
  StreamClock clock_;
  Duration transfer_{0};
  std::optional<Set> set_;  // under way
  Companion with_acceleration_;
  std::uint32_t good_ = 0, damage_ = 0;
};

}  // namespace

std::unique_ptr<ImuProtocol> makeWitmotionProtocol() { return std::make_unique<WitmotionProtocol>(); }

}  // namespace slam
