// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/sweep_watch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam {
namespace {

/// @param share [1] of the beams measured before
double timeOf(double share, double sweep, SweepWatch::Order order) {
  if (order == SweepWatch::Order::kAtOnce) return 0.0;
  return sweep * (order == SweepWatch::Order::kForward ? share : 1.0 - share);
}

/// T_odom_lidar at a share of the time between two of them.
Pose2 poseAt(const SweepWatch::Moved& moved, double share) {
  const double turn = wrapAngle(moved.end.theta - moved.begin.theta);
  return {moved.begin.x + share * (moved.end.x - moved.begin.x), moved.begin.y + share * (moved.end.y - moved.begin.y),
          moved.begin.theta + share * turn};
}

}  // namespace

std::size_t SweepWatch::binOf(double bearing) {
  const double turns = bearing / (2.0 * std::numbers::pi);
  return std::min<std::size_t>(bins() - 1, static_cast<std::size_t>(bins() * (turns - std::floor(turns))));
}

double SweepWatch::sweepOf(std::span<const Beam> beams) {
  double angle = 0.0;
  for (std::size_t i = 1; i < beams.size(); ++i)
    angle += std::abs(wrapAngle(static_cast<double>(beams[i].bearing) - static_cast<double>(beams[i - 1].bearing)));
  return std::min(1.0, angle / (2.0 * std::numbers::pi));
}

void SweepWatch::add(std::span<const Beam> beams, const RangeLimits& limits, Timestamp first, double interval,
                     const Moved& moved) {
  const double sweep = sweepOf(beams);
  if (!seen_ || first <= seen_->first || toSeconds(first - seen_->first) > config_.longest)
    return keep(beams, limits, first, sweep, moved);
  const double turned = std::abs(wrapAngle(moved.begin.theta - seen_->moved.begin.theta));
  if (turned < config_.turn) return;
  const auto rate = [&](const Moved& m) { return wrapAngle(m.end.theta - m.begin.theta) / interval; };
  const bool fast = std::min(rate(moved), rate(seen_->moved)) > config_.turn_rate ||
                    std::max(rate(moved), rate(seen_->moved)) < -config_.turn_rate;
  if (fast && turned < config_.most_turn) {
    const auto at_once = meets(beams, limits, moved, sweep, Order::kAtOnce);
    const auto forward = meets(beams, limits, moved, sweep, Order::kForward);
    const auto reverse = meets(beams, limits, moved, sweep, Order::kReverse);
    if (at_once && forward && reverse) count(*at_once, *forward, *reverse);
  }
  keep(beams, limits, first, sweep, moved);
}

/// [1] share of the beams that meet what the other scan saw there.
std::optional<double> SweepWatch::meets(std::span<const Beam> beams, const RangeLimits& limits, const Moved& moved,
                                        double sweep, Order order) const {
  int compared = 0, met = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Beam& beam = beams[i];
    if (!limits.contains(beam.range) || !std::isfinite(beam.bearing)) continue;
    const double bearing = beam.bearing, share = static_cast<double>(i) / static_cast<double>(beams.size());
    const Eigen::Vector2d p = poseAt(moved, timeOf(share, sweep, order)) *
                              Eigen::Vector2d(beam.range * std::cos(bearing), side_ * beam.range * std::sin(bearing));
    Eigen::Vector2d there = seen_->moved.begin.inverse() * p;
    for (int k = 0; k < 3; ++k) {  // where it was seen hangs on when, and that on where
      const float before = seen_->shares[binOf(side_ * std::atan2(there.y(), there.x()))];
      there = poseAt(seen_->moved, timeOf(before, seen_->sweep, order)).inverse() * p;
    }
    const std::size_t bin = binOf(side_ * std::atan2(there.y(), there.x()));
    const float range = seen_->ranges[bin];
    if (range == 0.0F || seen_->shares[bin] < 0.0F) continue;
    ++compared;
    met += std::abs(there.norm() - range) < config_.same_range;
  }
  return compared >= config_.fewest ? std::optional(static_cast<double>(met) / compared) : std::nullopt;
}

void SweepWatch::count(double at_once, double forward, double reverse) {
  const auto vote = [&](double share, double other) {
    return share > std::max(at_once, other) + config_.clearly_better ? 1 : at_once > share ? -1 : 0;
  };
  forward_ = std::clamp(forward_ + vote(forward, reverse), 0, config_.most);
  reverse_ = std::clamp(reverse_ + vote(reverse, forward), 0, config_.most);
  const int best = std::max(forward_, reverse_);
  if (best == 0) order_ = Order::kAtOnce;
  if (best >= config_.enough) order_ = forward_ > reverse_ ? Order::kForward : Order::kReverse;
}

void SweepWatch::keep(std::span<const Beam> beams, const RangeLimits& limits, Timestamp first, double sweep,
                      const Moved& moved) {
  if (!seen_) seen_ = Seen{};
  seen_->first = first;
  seen_->moved = moved;
  seen_->sweep = sweep;
  seen_->ranges.fill(0.0F);
  seen_->shares.fill(-1.0F);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (!std::isfinite(beams[i].bearing)) continue;
    const std::size_t bin = binOf(beams[i].bearing);
    seen_->shares[bin] = static_cast<float>(i) / static_cast<float>(beams.size());
    if (limits.contains(beams[i].range)) seen_->ranges[bin] = beams[i].range;
  }
  const Seen measured = *seen_;
  for (std::size_t bin = 0; bin < bins(); ++bin) {  // sparse beams leave bins between them
    for (const std::size_t beside : {(bin + 1) % bins(), (bin + bins() - 1) % bins()}) {
      if (seen_->shares[bin] >= 0.0F) continue;
      seen_->shares[bin] = measured.shares[beside];
      seen_->ranges[bin] = measured.ranges[beside];
    }
  }
}

}  // namespace slam
