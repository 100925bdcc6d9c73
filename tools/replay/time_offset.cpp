// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/pose2.hpp"

namespace slam {
namespace {

constexpr double kStep = 0.005;       // [s] of the raster
constexpr double kLongestTurn = 1.0;  // [s] between two matched scans, and between two gyro samples
constexpr double kOutlier = 0.1;      // [rad] a match that is off by more is no measurement of a turn
constexpr int kFewestTurns = 50;
constexpr double kDistinct = 0.7;       // [1] of the raster's median error that the best one may have
constexpr double kLargestSigma = 0.01;  // [s] a worse estimate is none

}  // namespace

void LidarGyroOffset::addGyro(Timestamp stamp, double rate) {
  if (!gyro_stamps_.empty() && stamp <= gyro_stamps_.back()) return;
  double angle = 0.0;
  if (!gyro_stamps_.empty()) {
    angle = gyro_angles_.back() + 0.5 * (rate + gyro_rates_.back()) * toSeconds(stamp - gyro_stamps_.back());
  }
  gyro_stamps_.push_back(stamp);
  gyro_rates_.push_back(rate);
  gyro_angles_.push_back(angle);
}

void LidarGyroOffset::addScan(Timestamp stamp, double heading) {
  if (last_scan_ && stamp > *last_scan_ && toSeconds(stamp - *last_scan_) < kLongestTurn) {
    turns_.push_back({*last_scan_, stamp, wrapAngle(heading - last_heading_)});
  }
  last_scan_ = stamp;
  last_heading_ = heading;
}

std::optional<double> LidarGyroOffset::turned(Timestamp stamp) const {
  const auto after = std::lower_bound(gyro_stamps_.begin(), gyro_stamps_.end(), stamp);
  if (after == gyro_stamps_.begin() || after == gyro_stamps_.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - gyro_stamps_.begin());
  const double interval = toSeconds(gyro_stamps_[i] - gyro_stamps_[i - 1]);
  if (interval > kLongestTurn) return std::nullopt;
  const double share = toSeconds(stamp - gyro_stamps_[i - 1]) / interval;
  return gyro_angles_[i - 1] + share * (gyro_angles_[i] - gyro_angles_[i - 1]);
}

std::optional<double> LidarGyroOffset::meanSquare(double shift, int* used) const {
  // angle = gyro's + bias * interval: the bias by linear regression through the origin.
  const Duration by = fromSeconds(shift);
  std::vector<std::pair<double, double>> pairs;  // difference [rad], interval [s]
  pairs.reserve(turns_.size());
  double sum_di = 0.0, sum_ii = 0.0;
  for (const Turn& turn : turns_) {
    const auto from = turned(turn.from + by), to = turned(turn.to + by);
    if (!from || !to) continue;
    const double difference = turn.angle - (*to - *from), interval = toSeconds(turn.to - turn.from);
    if (std::abs(difference) > kOutlier) continue;
    pairs.emplace_back(difference, interval);
    sum_di += difference * interval;
    sum_ii += interval * interval;
  }
  *used = static_cast<int>(pairs.size());
  if (*used < kFewestTurns || !(sum_ii > 0.0)) return std::nullopt;
  double sum = 0.0;
  for (const auto& [difference, interval] : pairs) {
    const double residual = difference - sum_di / sum_ii * interval;
    sum += residual * residual;
  }
  return sum / *used;
}

std::optional<LidarGyroOffset::Estimate> LidarGyroOffset::estimate() const {
  const int steps = static_cast<int>(std::lround(kMaxOffset / kStep));
  std::vector<double> errors;
  int used = 0;
  for (int i = -steps; i <= steps; ++i) {
    errors.push_back(meanSquare(i * kStep, &used).value_or(std::numeric_limits<double>::infinity()));
  }
  const int best = static_cast<int>(std::min_element(errors.begin(), errors.end()) - errors.begin()) - steps;
  if (std::abs(best) == steps) return std::nullopt;
  auto sorted = errors;
  std::nth_element(sorted.begin(), sorted.begin() + steps, sorted.end());
  if (errors[static_cast<std::size_t>(best + steps)] > kDistinct * sorted[static_cast<std::size_t>(steps)]) {
    return std::nullopt;  // any shift does as well: the robot hardly turned
  }
  const auto at = [&](int i) { return errors[static_cast<std::size_t>(i + steps)]; };
  const double slope = 0.5 * (at(best + 1) - at(best - 1)) / kStep;
  const double curvature = (at(best + 1) - 2.0 * at(best) + at(best - 1)) / (kStep * kStep);
  if (!(curvature > 0.0) || !std::isfinite(curvature)) return std::nullopt;
  // Of a least-squares sum S with the residuals' variance s^2, the minimum's variance is 2 s^2 / S''.
  meanSquare(best * kStep, &used);
  Estimate estimate{best * kStep - slope / curvature, std::sqrt(2.0 * at(best) / (curvature * used)), used};
  if (!(estimate.sigma < kLargestSigma)) return std::nullopt;
  return estimate;
}

}  // namespace slam
