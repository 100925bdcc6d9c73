// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>

#include "drivers/imu/codec/bno08x_frames.hpp"
#include "drivers/imu/imu_protocols.hpp"
#include "timing/stream_clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr double kFastest = 35.0;  // [rad/s] 2000 deg/s, where its gyro ends: more is a jump of the attitude
constexpr int kMostFrames = 10;    // between attitudes whose difference is a turn rate
constexpr Duration kSilence = 1s;  // then the index, which wraps in 2.56 s, counts nothing

/// [BNO08X] applies yaw, pitch and roll in this order, and calls pitch a rotation about y, roll one about x. The
/// accelerations of its own example contradict: by them pitch is about x and roll about y, as with Android. With the
/// unit level the two are one.
Eigen::Quaterniond attitudeOf(const bno08x::Frame& frame) {
  const auto radians = [](std::int16_t count) { return bno08x::kDegreesPerCount * count * std::numbers::pi / 180.0; };
  return Eigen::AngleAxisd(radians(frame.yaw), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(radians(frame.pitch), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(radians(frame.roll), Eigen::Vector3d::UnitY());
}

/// The turn rate is the difference of the attitudes two frames apart, at the instant of the frame between them. A step
/// of an angle, 0.01 deg, is 0.0087 rad/s of it; the rounding of both attitudes makes noise of 0.0036 rad/s (sigma).
/// Its sum over time stays within 0.01 deg: noise of one sample is taken back by those behind it, so the heading is as
/// good as the unit's own. That drifts, as it has no magnetometer in this mode. Between neighbours a step at rest would
/// be 0.0175 rad/s, and a swing from -1 to +1 step no standstill (StandstillConfig::max_gyro_swing).
class Bno08xProtocol : public ImuProtocol {
 public:
  void begin(int baud) override {
    frames_.reset();
    clock_ = StreamClock();
    before_.reset();
    middle_.reset();
    index_.reset();
    damage_ = damage();
    transfer_ = transferTime(bno08x::kFrameSize, baud);
  }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    frames_.push(byte, [&](std::span<const std::uint8_t> frame) { handle(bno08x::parse(frame), now, take); });
  }

  std::uint32_t frames() const override { return good_; }
  std::uint32_t damage() const override {
    return frames_.damaged() + frames_.skipped() / static_cast<std::uint32_t>(bno08x::kFrameSize) + jumps_;
  }

 private:
  struct Attitude {
    Timestamp stamp;
    std::uint8_t index;
    Eigen::Quaterniond q_world_unit;
    Eigen::Vector3d acceleration;  // [m/s^2] specific force
  };

  void handle(const bno08x::Frame& frame, Timestamp now, const Take& take) {
    ++good_;
    const bool follows = index_ && static_cast<std::uint8_t>(*index_ + 1) == frame.index;
    const bool lost = index_ && (!follows || damage() != damage_);
    index_ = frame.index;
    damage_ = damage();
    const Timestamp stamp = clock_.stamp(now - transfer_, lost);
    if (!clock_.learned()) return;
    const double unit = kStandardGravity * bno08x::kGravitiesPerCount;
    const Eigen::Vector3d acceleration(frame.acceleration[0], frame.acceleration[1], frame.acceleration[2]);
    const Attitude last{stamp, frame.index, attitudeOf(frame), unit * acceleration};
    if (middle_ && stamp - middle_->stamp > kSilence) {
      before_.reset();
      middle_.reset();
    }
    if (before_) emit(*before_, *middle_, last, take);
    before_ = middle_;
    middle_ = last;
  }

  /// The unit counts its frames: so the time between two is known, also where a computer that was busy took many at
  /// once.
  void emit(const Attitude& before, const Attitude& middle, const Attitude& last, const Take& take) {
    const int frames = static_cast<std::uint8_t>(last.index - before.index);
    if (frames < 2 || frames > kMostFrames) return;
    const Eigen::AngleAxisd turn(before.q_world_unit.conjugate() * last.q_world_unit);
    const double angle = std::remainder(turn.angle(), 2.0 * std::numbers::pi);
    const Eigen::Vector3d rate = angle / (frames * clock_.period()) * turn.axis();
    if (!(rate.norm() < kFastest)) {
      ++jumps_;
      middle_.reset();  // begins anew with the last one
      return;
    }
    take({before.stamp + (last.stamp - before.stamp) / 2, rate, middle.acceleration});
  }

  bno08x::Decoder frames_;
  StreamClock clock_;
  Duration transfer_{0};
  std::optional<Attitude> before_, middle_;
  std::optional<std::uint8_t> index_;
  std::uint32_t good_ = 0, jumps_ = 0, damage_ = 0;
};

}  // namespace

std::unique_ptr<ImuProtocol> makeBno08xProtocol() { return std::make_unique<Bno08xProtocol>(); }

}  // namespace slam
