// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "core/pose2.hpp"

namespace slam {
namespace {

constexpr double kLongestTurn = 1.0;  // [s] between two matched scans, and between two gyro samples
constexpr double kOutlier = 0.1;      // [rad] a match that is off by more is no measurement of a turn
constexpr int kFewestTurns = 50;
constexpr double kDistinct = 0.7;       // [1] of the raster's median error that the best one may have
constexpr double kLargestSigma = 0.01;  // [s] a worse estimate is none

}  // namespace

void LidarGyroOffset::addGyro(Timestamp stamp, double rate) {
  if (!gyro_.empty() && stamp <= gyro_.back().stamp) return;
  double angle = 0.0;
  if (!gyro_.empty()) {
    const GyroSample& last = gyro_.back();
    angle = last.angle + 0.5 * (rate + last.rate) * toSeconds(stamp - last.stamp);
  }
  gyro_.push_back({stamp, rate, angle});
  const Duration reach = fromSeconds(kMaxOffset);
  for (; !waiting_.empty() && stamp > waiting_.front().to + reach; waiting_.pop_front()) add(waiting_.front(), raster_);
  // The next turn may begin a turn's length before now, and its scans come late.
  const Timestamp next = stamp - fromSeconds(2.0 * kLongestTurn);
  const Timestamp oldest = (waiting_.empty() ? next : std::min(next, waiting_.front().from)) - reach;
  while (gyro_.size() > 2 && gyro_[1].stamp < oldest) gyro_.pop_front();
}

void LidarGyroOffset::addScan(Timestamp stamp, double heading) {
  if (last_scan_ && stamp > *last_scan_ && toSeconds(stamp - *last_scan_) < kLongestTurn) {
    waiting_.push_back({*last_scan_, stamp, wrapAngle(heading - last_heading_)});
  }
  last_scan_ = stamp;
  last_heading_ = heading;
}

std::optional<double> LidarGyroOffset::turned(Timestamp stamp) const {
  const auto after = std::lower_bound(gyro_.begin(), gyro_.end(), stamp,
                                      [](const GyroSample& sample, Timestamp at) { return sample.stamp < at; });
  if (after == gyro_.begin() || after == gyro_.end()) return std::nullopt;
  const GyroSample& before = *std::prev(after);
  const double interval = toSeconds(after->stamp - before.stamp);
  if (interval > kLongestTurn) return std::nullopt;
  return before.angle + toSeconds(stamp - before.stamp) / interval * (after->angle - before.angle);
}

void LidarGyroOffset::add(const Turn& turn, Raster& raster) const {
  const double interval = toSeconds(turn.to - turn.from);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const Duration by = fromSeconds(i * kStep);
    const auto from = turned(turn.from + by), to = turned(turn.to + by);
    if (!from || !to) continue;
    const double difference = turn.angle - (*to - *from);
    if (std::abs(difference) > kOutlier) continue;
    Sums& sums = raster[static_cast<std::size_t>(i + kSteps)];
    ++sums.used;
    sums.dd += difference * difference;
    sums.di += difference * interval;
    sums.ii += interval * interval;
  }
}

std::optional<LidarGyroOffset::Estimate> LidarGyroOffset::estimate() const {
  Raster raster = raster_;
  for (const Turn& turn : waiting_) add(turn, raster);
  std::vector<double> errors;  // mean square: angle = gyro's + bias * interval, the bias by regression
  for (const Sums& sums : raster) {
    const bool enough = sums.used >= kFewestTurns && sums.ii > 0.0;
    errors.push_back(enough ? (sums.dd - sums.di * sums.di / sums.ii) / sums.used
                            : std::numeric_limits<double>::infinity());
  }
  const int best = static_cast<int>(std::min_element(errors.begin(), errors.end()) - errors.begin()) - kSteps;
  if (std::abs(best) == kSteps) return std::nullopt;
  auto sorted = errors;
  std::nth_element(sorted.begin(), sorted.begin() + kSteps, sorted.end());
  if (errors[static_cast<std::size_t>(best + kSteps)] > kDistinct * sorted[static_cast<std::size_t>(kSteps)]) {
    return std::nullopt;  // any shift does as well: the robot hardly turned
  }
  const auto at = [&](int i) { return errors[static_cast<std::size_t>(i + kSteps)]; };
  const double slope = 0.5 * (at(best + 1) - at(best - 1)) / kStep;
  const double curvature = (at(best + 1) - 2.0 * at(best) + at(best - 1)) / (kStep * kStep);
  if (!(curvature > 0.0) || !std::isfinite(curvature)) return std::nullopt;
  // Of a least-squares sum S with the residuals' variance s^2, the minimum's variance is 2 s^2 / S''.
  const int used = raster[static_cast<std::size_t>(best + kSteps)].used;
  Estimate estimate{best * kStep - slope / curvature, std::sqrt(2.0 * at(best) / (curvature * used)), used};
  if (!(estimate.sigma < kLargestSigma)) return std::nullopt;
  return estimate;
}

}  // namespace slam
