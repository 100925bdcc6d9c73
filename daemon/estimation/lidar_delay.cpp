// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/lidar_delay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/pose2.hpp"

namespace slam {

LidarDelay::LidarDelay(const LidarDelayConfig& config)
    : config_(config),
      steps_(static_cast<int>(std::lround(config.reach / config.step))),
      raster_(static_cast<std::size_t>(2 * steps_ + 1)),
      differences_(raster_.size()) {}

void LidarDelay::Sums::add(double difference, double interval, double angle) {
  ++used;
  dd += difference * difference;
  di += difference * interval;
  ii += interval * interval;
  turned += angle * angle;
}

void LidarDelay::addGyro(Timestamp stamp, double rate) {
  if (!std::isfinite(rate)) return;
  double angle = 0.0;
  if (gyro_count_ > 0) {
    const GyroSample& last = gyro(gyro_count_ - 1);
    if (stamp <= last.stamp) return;
    angle = last.angle + 0.5 * (rate + last.rate) * toSeconds(stamp - last.stamp);
  }
  if (gyro_count_ == gyro_.size()) gyro_begin_ = (gyro_begin_ + 1) % gyro_.size(), --gyro_count_;
  gyro_[(gyro_begin_ + gyro_count_++) % gyro_.size()] = {stamp, rate, angle};
  const Timestamp complete = stamp - fromSeconds(config_.reach);
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
  const auto later = std::find_if(waiting_.begin(), end, [&](const Turn& turn) { return turn.to >= complete; });
  std::for_each(waiting_.begin(), later, [this](const Turn& turn) { add(turn); });
  waiting_count_ = static_cast<std::size_t>(std::move(later, end, waiting_.begin()) - waiting_.begin());
}

std::optional<GyroBias> LidarDelay::addScan(Timestamp stamp, double heading) {
  stamp -= used_;
  const bool follows = last_scan_ && stamp > *last_scan_ && toSeconds(stamp - *last_scan_) < config_.longest;
  if (follows && waiting_count_ < waiting_.size())
    waiting_[waiting_count_++] = {*last_scan_, stamp, wrapAngle(heading - last_heading_)};
  last_scan_ = stamp;
  last_heading_ = heading;
  const auto estimated = estimate();
  return estimated && use(*estimated) ? std::optional(estimated->gyro_bias) : std::nullopt;
}

std::optional<double> LidarDelay::angleAt(Timestamp stamp) const {
  std::size_t before = 0, after = gyro_count_;  // the first sample at or behind the stamp
  while (before < after) {
    const std::size_t middle = (before + after) / 2;
    (gyro(middle).stamp < stamp ? before : after) = gyro(middle).stamp < stamp ? middle + 1 : middle;
  }
  if (after == 0 || after == gyro_count_) return std::nullopt;
  const GyroSample &a = gyro(after - 1), &b = gyro(after);
  const double interval = toSeconds(b.stamp - a.stamp);
  if (interval > config_.longest) return std::nullopt;
  return a.angle + toSeconds(stamp - a.stamp) / interval * (b.angle - a.angle);
}

std::optional<double> LidarDelay::gyroTurn(const Turn& turn, int step) const {
  const auto from = angleAt(turn.from + fromSeconds(step * config_.step)),
             to = angleAt(turn.to + fromSeconds(step * config_.step));
  return from && to ? std::optional(*to - *from) : std::nullopt;
}

void LidarDelay::add(const Turn& turn) {
  const double interval = toSeconds(turn.to - turn.from);
  const auto earliest = gyroTurn(turn, -steps_), latest = gyroTurn(turn, steps_), whole = gyroTurn(turn, 0);
  if (!earliest || !latest || !whole) return;
  // At rest, or in an even turn, all shifts are alike.
  const bool even = std::max(std::abs(*earliest - *whole), std::abs(*latest - *whole)) < config_.small_turn * interval;
  bool possible = false;
  for (int step = -steps_; step <= steps_; ++step) {
    const auto by_gyro = even ? whole : gyroTurn(turn, step);
    differences_[index(step)] = by_gyro ? std::optional(turn.angle - *by_gyro) : std::nullopt;
    possible |= by_gyro && std::abs(turn.angle - *by_gyro) < config_.outlier;
  }
  if (!possible) return;  // the match was wrong
  for (std::size_t i = 0; i < raster_.size(); ++i)
    if (const auto& difference = differences_[i])
      raster_[i].add(std::clamp(*difference, -config_.outlier, config_.outlier), interval, turn.angle);
}

/// [rad^2] mean square of what a shift leaves unexplained.
double LidarDelay::error(int step) const {
  const Sums& sums = at(step);
  if (sums.used < config_.fewest_turns) return std::numeric_limits<double>::infinity();
  return sums.left() / sums.used;
}

/// The shift that explains the turns; nothing where it lies at an end, or hardly any turn shows it.
std::optional<int> LidarDelay::best() const {
  int best = 0;
  double sum = 0.0;
  for (int step = -steps_; step <= steps_; ++step) {
    sum += error(step);
    if (error(step) < error(best)) best = step;
  }
  if (std::abs(best) == steps_) return std::nullopt;
  if (!(error(best) < config_.distinct * sum / static_cast<double>(raster_.size()))) return std::nullopt;
  return best;
}

std::optional<LidarDelay::Estimate> LidarDelay::estimate() const {
  const auto shift = best();
  if (!shift) return std::nullopt;
  const double left = error(*shift - 1), middle = error(*shift), right = error(*shift + 1);
  const double slope = 0.5 * (right - left) / config_.step;
  const double curvature = (right - 2.0 * middle + left) / (config_.step * config_.step);
  if (!(curvature > 0.0) || !std::isfinite(curvature)) return std::nullopt;
  // Of a least-squares sum S with the residuals' variance s^2, the minimum's variance is 2 s^2 / S''.
  const Sums& sums = at(*shift);
  Estimate estimate{.offset = *shift * config_.step - slope / curvature,
                    .sigma = std::sqrt(2.0 * middle / (curvature * sums.used)),
                    .turns = sums.used,
                    .gyro_bias = {-sums.di / sums.ii, middle / sums.ii}};
  if (!(estimate.sigma < config_.largest_sigma)) return std::nullopt;
  return estimate;
}

/// Uses an estimate that explains the turns so much better than what is used. One that would do little harm is as none.
bool LidarDelay::use(const Estimate& estimate) {
  const double offset = std::abs(estimate.offset) < config_.least_error ? 0.0 : estimate.offset;
  if (std::abs(offset - toSeconds(used_)) < config_.least_change) return false;
  const auto nearest = [this](double shift) { return static_cast<int>(std::lround(shift / config_.step)); };
  const Sums& sums = at(nearest(offset));
  if (sums.turned < config_.least_turned || sums.left() > config_.unexplained * sums.turned) return false;
  const double gain = 0.5 * estimate.turns * std::log(error(nearest(toSeconds(used_))) / error(nearest(offset)));
  if (!(gain > config_.likelihood_gain)) return false;
  used_ = fromSeconds(offset);
  return true;
}

}  // namespace slam
