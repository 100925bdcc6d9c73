// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/samples.hpp"
#include "core/timestamp.hpp"

namespace slam {

struct LidarDelayConfig {
  double reach = 0.25;       ///< [s] of the raster, on either side ...
  double step = 0.005;       ///< [s] ... and between its shifts
  double least_error = 0.1;  ///< [s] of the lidar's stamps: less does little harm, and scans that are bent show as much
  double least_change = 0.02;   ///< [s] of what is used
  double least_turned = 0.3;    ///< [rad^2] of all turns' squares before anything is used
  double largest_sigma = 0.01;  ///< [s] a worse estimate is none
  double distinct = 0.7;        ///< [1] of the raster's mean error that the best shift may have
  double unexplained = 0.1;     ///< [1] of the turns' squares that it may leave
  double likelihood_gain =
      14.0;                   ///< [1] logarithm by which a shift must be likelier than the one in use: a million times
  double outlier = 0.1;       ///< [rad] a match that is off by more at any shift is no measurement of a turn
  double longest = 1.0;       ///< [s] between two matched scans, and between two gyro samples
  double small_turn = 0.005;  ///< [rad/s] by which the rate of a turn that shows no shift changes
  int fewest_turns = 20;
};

/// How much the lidar's stamps are off the gyro's: between two matched scans the robot turned by what the gyro measured
/// in the same interval, if both clocks agree. The error is the shift of the scans at which the two differ least (least
/// squares over the shift and the gyro's bias; parabola through the best of a raster). It is used from where it is
/// much likelier than none.
///
/// No allocation after construction.
class LidarDelay {
 public:
  explicit LidarDelay(const LidarDelayConfig& config = {});

  /// @param rate [rad/s] about z
  void addGyro(Timestamp stamp, double rate);
  /// A matched scan, up to 2 s after the gyro's newest sample. @param stamp with used() added
  /// @param heading [rad] by the match @return the gyro's bias by the same turns, where used() has changed
  std::optional<GyroBias> addScan(Timestamp stamp, double heading);
  /// The next scan's turn is unknown: a scan between was not matched, or the map moved.
  void interrupt() { last_scan_.reset(); }

  struct Estimate {
    double offset = 0.0;  ///< [s] to be added to the lidar's stamps
    double sigma = 0.0;   ///< [s]
    int turns = 0;        ///< scan pairs used
    GyroBias gyro_bias;   ///< by the same turns
  };
  /// @return nothing where too little is known: no gyro, hardly a turn, or an offset beyond the raster
  std::optional<Estimate> estimate() const;
  /// What of it is to be added to the lidar's stamps.
  Duration used() const { return used_; }

 private:
  struct GyroSample {
    Timestamp stamp;
    double rate = 0.0, angle = 0.0;  // [rad/s], [rad] turned since the first sample
  };
  struct Turn {
    Timestamp from, to;
    double angle = 0.0;  // [rad]
  };
  /// Of the turns, at one shift: differences d from the gyro's angle [rad] in intervals i [s].
  struct Sums {
    int used = 0;
    double dd = 0.0, di = 0.0, ii = 0.0, turned = 0.0;  // the last: the turns' squares

    void add(double difference, double interval, double angle);
    double left() const { return dd - di * di / ii; }  // [rad^2] with the bias by regression
  };

  const GyroSample& gyro(std::size_t i) const { return gyro_[(gyro_begin_ + i) % gyro_.size()]; }
  std::optional<double> angleAt(Timestamp stamp) const;
  std::optional<double> gyroTurn(const Turn& turn, int step) const;
  void add(const Turn& turn);
  std::size_t index(int step) const { return static_cast<std::size_t>(step + steps_); }
  const Sums& at(int step) const { return raster_[index(step)]; }
  double error(int step) const;
  std::optional<int> best() const;
  bool use(const Estimate& estimate);

  LidarDelayConfig config_;
  std::array<GyroSample, 1024> gyro_{};  // a ring
  std::size_t gyro_begin_ = 0, gyro_count_ = 0;
  std::array<Turn, 32> waiting_{};  // until the gyro has come so far that the largest shift can be compared
  std::size_t waiting_count_ = 0;
  int steps_;  // of the raster, to either side of 0
  std::vector<Sums> raster_;
  std::vector<std::optional<double>> differences_;  // [rad] of a turn at each shift
  std::optional<Timestamp> last_scan_;
  double last_heading_ = 0.0;
  Duration used_{0};
};

}  // namespace slam
