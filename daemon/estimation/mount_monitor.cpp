// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/mount_monitor.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

namespace slam {

MountMonitor::MountMonitor(const Eigen::Matrix3d& prior, const MountMonitorConfig& config)
    : config_(config), prior_(prior) {
  error_.covariance = prior;
}

void MountMonitor::compare(const Pose2& T_odom_base, const Pose2& T_map_base, bool seen) {
  if (!seen) return interrupt();
  const Poses now{T_odom_base, T_map_base};
  const Poses from = begin_.value_or(now);
  const Pose2 wheels = between(from.T_odom_base, T_odom_base), scans = between(from.T_map_base, T_map_base);
  const double way = wheels.translation().norm(), turn = std::abs(scans.theta);
  if (begin_ && way < config_.interval && turn < config_.interval) return;
  const bool complete = begin_.has_value();
  begin_ = now;
  if (!complete) return;
  const auto square = [](double value) { return value * value; };
  Interval& interval = intervals_[count_++ % intervals_.size()];
  interval = {wheels.translation(), scans.translation(), scans.theta};
  interval.slipped = std::abs(wrapAngle(wheels.theta - scans.theta)) > config_.same_turn * (1.0 + turn);
  interval.variance =
      square(config_.match_sigma) + square(config_.wheel_sigma) * way + square(config_.turn_sigma * turn);
  estimate();
}

/// Of (1), by which it multiplies the unknowns.
MountMonitor::Rows MountMonitor::rowsOf(const Interval& interval) {
  const Eigen::Vector2d& w = interval.wheels;
  const double c = std::cos(interval.turn) - 1.0, s = std::sin(interval.turn);
  Rows rows;
  rows << w.x(), w.y(), c, -s, w.y(), -w.x(), s, c;
  return rows;
}

/// @param variance [1] of the ways, in those that were expected  @param counts whether an interval does
template <typename Filter>
MountMonitor::Solution MountMonitor::solve(double variance, Filter counts) const {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  information(0, 0) = 1.0 / (config_.scale_sigma * config_.scale_sigma);
  // A mount that is off by more than it was measured to was measured less well.
  const Eigen::Vector3d prior = prior_.diagonal() + error_.mean.cwiseAbs2();
  information(1, 1) = 1.0 / prior[2];
  information(2, 2) = 1.0 / prior[0];
  information(3, 3) = 1.0 / prior[1];
  Eigen::Vector4d sum = information.col(0);
  const std::size_t size = std::min(count_, intervals_.size());
  for (std::size_t i = 0; i < size; ++i) {
    const Interval& interval = intervals_[(count_ - size + i) % intervals_.size()];
    if (interval.slipped || !counts(interval, 2 * i < size)) continue;
    const Rows rows = rowsOf(interval);
    const double weight = interval.weight / (variance * interval.variance);
    information += weight * rows.transpose() * rows;
    sum += weight * rows.transpose() * interval.scans;
  }
  const Eigen::Matrix4d covariance = information.inverse();
  return {covariance * sum, covariance};
}

void MountMonitor::estimate() {
  error_ = {Eigen::Vector3d::Zero(), prior_};
  if (!(prior_.diagonal().minCoeff() > 0.0)) return;
  const std::span<Interval> intervals(intervals_.data(), std::min(count_, intervals_.size()));
  const auto sound = static_cast<double>(std::ranges::count(intervals, false, &Interval::slipped));
  if (sound < config_.mostly * static_cast<double>(intervals.size())) return;

  const auto all = [](const Interval&, bool) { return true; };
  const auto errorOf = [](const Solution& solution) {
    const Eigen::Vector4d& v = solution.value;
    return Eigen::Vector3d(v[2], v[3], v[1] / v[0]);
  };
  for (Interval& interval : intervals) interval.weight = 1.0;
  double variance = 1.0;
  error_.mean.setConstant(config_.interval);  // no prior: what the first ways show would take long to widen it
  Solution whole = solve(variance, all);
  for (int round = 0; round < config_.rounds; ++round) {
    double squares = config_.expected, weights = config_.expected;
    for (Interval& interval : intervals) {
      if (interval.slipped) continue;
      const Eigen::Vector2d residual = interval.scans - rowsOf(interval) * whole.value;
      const double normalised = 0.5 * residual.squaredNorm() / interval.variance;
      interval.weight = 1.0 / (1.0 + normalised / (variance * config_.outlier * config_.outlier));
      squares += interval.weight * normalised;
      weights += interval.weight;
    }
    variance = std::max(config_.least_share, squares / weights);
    error_.mean = errorOf(whole);
    whole = solve(variance, all);
  }

  // What differs from group to group is no mount. A group that shows nothing, as the left turns of a robot that only
  // turned right, stays at the prior, and confirms nothing.
  error_.mean = errorOf(whole);
  const auto differ = [&](auto one, auto other) -> Eigen::Vector3d {
    const Eigen::Vector3d from_one = errorOf(solve(variance, one)) - error_.mean;
    const Eigen::Vector3d from_other = errorOf(solve(variance, other)) - error_.mean;
    return from_one.cwiseAbs().cwiseMax(from_other.cwiseAbs());
  };
  const Eigen::Vector3d halves =
      differ([](const Interval&, bool first) { return first; }, [](const Interval&, bool first) { return !first; });
  const Eigen::Vector3d sides = differ([](const Interval& i, bool) { return i.turn >= 0.0; },
                                       [](const Interval& i, bool) { return i.turn <= 0.0; });
  const std::array order = {2, 3, 1};  // of x, y, yaw among the unknowns
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k)
      error_.covariance(i, k) =
          whole.covariance(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(k)]);
    error_.covariance(i, i) += std::max(halves[i] * halves[i], sides[i] * sides[i]);
  }
}

}  // namespace slam
