// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <deque>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

/// How much the lidar's stamps are off the gyro's, from a log: between two matched scans the robot turned by what the
/// gyro says of the same interval, if both clocks agree. The offset is the shift of the scans at which the two
/// differ least (least squares over the shift and the gyro's bias; parabola through the best of a raster). Keeps the
/// sums of the raster and the last seconds, however long the log is.
class LidarGyroOffset {
 public:
  /// @param rate [rad/s] about z
  void addGyro(Timestamp stamp, double rate);
  /// A scan that was matched, up to 2 s after the gyro's newest sample. @param heading [rad] by the match
  void addScan(Timestamp stamp, double heading);

  struct Estimate {
    double offset = 0.0;  ///< [s] to be added to the lidar's stamps
    double sigma = 0.0;   ///< [s]
    int turns = 0;        ///< scan pairs used
  };
  /// @return nothing where the log says too little: no gyro, hardly a turn, or an offset beyond the raster
  std::optional<Estimate> estimate() const;

  static constexpr double kMaxOffset = 0.25;  ///< [s] of the raster, on either side

 private:
  static constexpr int kSteps = 50;                     // of the raster, to either side of 0
  static constexpr double kStep = kMaxOffset / kSteps;  // [s]
  struct GyroSample {
    Timestamp stamp;
    double rate, angle;  // [rad/s], [rad] turned since the first sample
  };
  struct Turn {
    Timestamp from, to;
    double angle;  // [rad]
  };
  /// Of the turns, at one shift: differences d from the gyro's angle [rad] in intervals i [s].
  struct Sums {
    int used = 0;
    double dd = 0.0, di = 0.0, ii = 0.0;
  };
  using Raster = std::array<Sums, 2 * kSteps + 1>;

  /// [rad] that the gyro has turned since its first sample, linear between samples; nothing outside of them
  std::optional<double> turned(Timestamp stamp) const;
  void add(const Turn& turn, Raster& raster) const;

  std::deque<GyroSample> gyro_;  // as far back as the turns that wait
  std::deque<Turn> waiting_;     // until the gyro has come so far that the largest shift can be compared
  Raster raster_;
  std::optional<Timestamp> last_scan_;
  double last_heading_ = 0.0;
};

}  // namespace slam
