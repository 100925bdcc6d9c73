// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/pose_history.hpp"
#include "core/samples.hpp"
#include "estimation/ekf.hpp"

namespace slam {

/// What matched scans and wheels show of the gyro, from the worst up.
enum class GyroReliability : std::uint8_t {
  kNone,      ///< there is none
  kRejected,  ///< it is further from the scans' turns than the wheels are: none is better
  kUnproven,  ///< no turn has shown yet that it is right
  kReliable,
};

/// Why a gyro is rejected, as far as its turns show; the value beside it.
enum class GyroFault : std::uint8_t {
  kNone,
  kReversed,  ///< it turns the other way
  kDegrees,   ///< [1] its turns / the scans': about 57, it is in deg/s
  kScale,     ///< [1] its turns / the scans'
  kOffset,    ///< [rad/s] it reads at rest
  kClipped,   ///< [rad/s] it reads no more; below, it is right and used
  kUnrelated  ///< none of these
};

struct GyroVerdict {
  GyroReliability reliability = GyroReliability::kNone;
  GyroFault fault = GyroFault::kNone;
  double value = 0.0;  ///< by the fault
};

struct GyroMonitorConfig {
  double memory = 20.0;        ///< [1] intervals that are remembered
  double interval = 0.05;      ///< [rad] an interval is a turn of so much by any sensor ...
  double longest = 1.0;        ///< [s] ... or lasts as long
  double scan_turn = 0.01;     ///< [rad] error of a turn between two matched scans, seldom more
  double worse = 2.0;          ///< [1] times the wheels' error, from which on the gyro's is a vote against it
  double rejected = 0.5;       ///< [1] share of votes against it from which on it is rejected ...
  double agreement = 0.2;      ///< [1] ... until it is below this
  int least = 5;               ///< intervals, or equal readings, that prove anything
  double large_offset = 0.05;  ///< [rad/s] is worth a word
  double prior_sigma = 0.2;    ///< [1, rad/s] of scale and offset before anything is known of them
  double off_scale = 0.3;      ///< [1] of a scale that explains a fault
  double beyond = 0.06;        ///< [s] that a sensor lags behind another, seldom more
};

/// Assesses the gyro by the turn from one matched scan to another, beside the wheels: where scans and wheels agree and
/// the gyro does not, it is wrong, and it is better to have none. Wheels that slip, or scans that are wrong, are no
/// reason: there the gyro is no further from the scans than the wheels are. Before a turn has shown that it is right,
/// wheels that contradict it are trusted until the scans have decided.
///
///     turn_gyro = scale * turn_scans + offset * time      (least squares, old intervals fade)
///
/// shows why it is wrong, and the offset with which it is used again. A sensor with noise repeats its
/// largest reading only at the end of its range: where scans turn faster meanwhile, that reading is no measurement.
///
/// No allocation after construction.
class GyroMonitor {
 public:
  explicit GyroMonitor(const EkfConfig& noise, const GyroMonitorConfig& config = {});

  /// @param bias [rad/s] of the filter
  /// @return whether these wheels have just shown that an unproven gyro may be wrong
  bool add(const WheelSample& sample, double bias);
  /// @return the sample for the filters, with its rate marked as unknown where that is not to be trusted
  ImuSample add(const ImuSample& sample);

  /// Compares with a matched scan. @param theta [rad] heading that it shows @param bias [rad/s] of the filter
  /// @return the bias with which the gyro is to be used again, where it has just been found to agree
  std::optional<GyroBias> compare(Timestamp stamp, double theta, double bias);
  /// The interval has no end: the scans did not show it, or the map moved.
  void interrupt() { begin_.reset(); }
  /// The scans were stamped wrongly so far: what they showed of the gyro is nothing.
  void forget();

  /// Turn by the gyro as it reads, bias and all [rad]; none where it has no samples, or is not to be trusted.
  std::optional<double> turned(Timestamp from, Timestamp to) const;

  bool reliable() const { return !rejected_; }
  int rejections() const { return rejections_; }
  /// @param bias [rad/s] of the filter
  GyroVerdict verdict(double bias) const;

 private:
  struct Turn {
    double seconds = 0.0;
    double scans = 0.0, gyro = 0.0;  // [rad]
    double pinned = 0.0;             // [s] that the gyro repeated its largest reading
    std::optional<double> wheels;    // [rad]
  };
  struct Instant {
    Timestamp stamp;
    Turn turn;  // from the beginning to there
  };
  std::optional<Instant> at(Timestamp stamp, double theta) const;
  std::optional<double> turned(const PoseHistory& sensor, Timestamp from, Timestamp to) const;
  void learnRange(const Turn& turn, double bias);
  void learnRelation(const Turn& turn);
  std::optional<GyroBias> vote(const Turn& turn, double bias);
  void begin(bool rejected);
  Eigen::Vector2d relation() const;  // scale [1] and offset [rad/s]
  double offset() const;

  EkfConfig noise_;
  GyroMonitorConfig config_;
  PoseHistory gyro_, wheels_;  // x: [rad] turned since the beginning, y: [s] that the largest reading was repeated
  double last_rate_ = 0.0;     // [rad/s] reading
  std::optional<double> last_wheels_;  // [rad]
  std::optional<Instant> begin_;
  Eigen::Matrix2d information_ = Eigen::Matrix2d::Zero();  // of scale and offset, in units of scan_turn
  Eigen::Vector2d gradient_ = Eigen::Vector2d::Zero();
  double against_ = 0.0;  // [1] share of votes
  int votes_ = 0, proofs_ = 0, rejections_ = 0;
  bool has_samples_ = false, rejected_ = false;
  double largest_ = 0.0;  // [rad/s] reading
  int repeated_ = 0;      // of it
  bool clipped_ = false;
};

}  // namespace slam
