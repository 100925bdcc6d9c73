// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "core/timestamp.hpp"
#include "drivers/can/pace.hpp"
#include "firmware_if/can_odrive.hpp"

namespace slam {

/// How the drives' encoders turn with the wheels.
struct CanWheelsConfig {
  std::array<double, 2> sign{1.0, 1.0};  ///< left, right: -1 where driving forward counts down (mirrored motors)
  double gear_ratio = 1.0;               ///< turns of the encoder per turn of the wheel
  double max_speed = 100.0;              ///< [rad/s] of a wheel: what is faster is damage, not motion
};

/// Adds up one wheel's encoder estimates. Their position is a single since the drive's start: only differences are
/// used, added in double, so that its coarse steps never add up. An estimate that is out of line with the one before,
/// by what it says of its speed, is left out, and so are those behind it until ten in a row have agreed: a drive that
/// was reset counts anew from there, and damaged frames never come to ten.
class CanWheel {
 public:
  struct Reading {
    Timestamp stamp;
    double angle = 0.0;  // [rad] since the first reading, positive forward
    double speed = 0.0;  // [rad/s]
  };
  enum class Outcome : std::uint8_t {
    kGoodOn,     ///< in line with the reading before
    kGoodAnew,   ///< the first, or the first after a silence or a reset: no difference to what was before
    kRejected,   ///< no motion of a wheel
    kStepsBack,  ///< stamped no later than the reading before
  };

  /// @param scale [rad] of the wheel, forward, for one turn of the encoder
  CanWheel(double scale, double max_speed) : scale_(scale), max_speed_(max_speed) {}

  Outcome add(Timestamp stamp, const can::odrive::EncoderEstimates& estimates);
  const Reading& last() const { return last_; }
  /// At which its estimates come, learned; 0: not known yet.
  Duration period() const { return pace_.period(); }
  /// Angle at an instant not after the last reading, between the last two by their angles and speeds.
  double angleAt(Timestamp stamp) const;

 private:
  struct Count {
    Timestamp stamp;
    double angle;  // [rad] as the drive counts
    double speed;  // [rad/s]
  };
  // Random estimates pass as a standing wheel's, each with a chance of a third.
  static constexpr int kTrusted = 10;

  bool follows(const Count& before, const Count& now) const;
  bool trust(const Count& now);

  double scale_, max_speed_;
  Pace pace_;                            // of the estimates, believed or not
  std::optional<Count> count_, newest_;  // the last one used, the last one that can be read
  int in_line_ = kTrusted;               // with the one before, how many in a row; the first of all is believed
  Reading last_;
  std::optional<Reading> previous_;  // in line with the last
};

/// Brings the estimates of two wheels, which come at moments of their own, to one instant: that of the older of the two
/// newest, where one was measured and the other is interpolated. How far apart they may be follows from the period at
/// which each drive sends, which is learned.
class CanWheels {
 public:
  struct Pair {
    Timestamp stamp;
    std::array<double, 2> angles{};  ///< [rad] left, right; positive forward
    bool restarted = false;          ///< no difference to the pair before
  };

  explicit CanWheels(const CanWheelsConfig& config);

  /// @param side 0 left, 1 right @return a pair when both wheels have a reading newer than the pair before
  std::optional<Pair> add(std::size_t side, Timestamp stamp, const can::odrive::EncoderEstimates& estimates);
  /// Frames of a wheel that cannot be read.
  void reject() { ++rejects_; }
  /// The next pair is not to be compared with the one before.
  void beginAnew() { restarted_ = true; }
  std::int64_t rejects() const {
    return rejects_;
  }  ///< estimates that no wheel can have turned, and what reject() counts
  Duration period(std::size_t side) const { return wheels_[side].period(); }

 private:
  std::array<CanWheel, 2> wheels_;
  std::array<bool, 2> fresh_{};
  bool restarted_ = true;
  std::int64_t rejects_ = 0;
};

}  // namespace slam
