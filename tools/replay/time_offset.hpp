// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <vector>

#include "core/timestamp.hpp"

namespace slam {

/// How much the lidar's stamps are off the gyro's, from a log: between two matched scans the robot turned by what the
/// gyro says of the same interval, if both clocks agree. The offset is the shift of the scans at which the two
/// differ least (least squares over the shift and the gyro's bias; parabola through the best of a raster).
class LidarGyroOffset {
 public:
  /// @param rate [rad/s] about z
  void addGyro(Timestamp stamp, double rate);
  /// A scan that was matched. @param heading [rad] by the match
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
  struct Turn {
    Timestamp from, to;
    double angle;  // [rad]
  };
  /// [rad] that the gyro has turned since its first sample, linear between samples; nothing outside of them
  std::optional<double> turned(Timestamp stamp) const;
  std::optional<double> meanSquare(double shift, int* used) const;

  std::vector<Timestamp> gyro_stamps_;
  std::vector<double> gyro_rates_, gyro_angles_;
  std::vector<Turn> turns_;
  std::optional<Timestamp> last_scan_;
  double last_heading_ = 0.0;
};

}  // namespace slam
