// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/intake/stuck_scan_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "frontend/interpreter/bearing_bins.hpp"

namespace slam {

StuckScanDetector::StuckScanDetector(const ScanRepeatConfig& config, double side) : config_(config) {
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const double bearing = 2.0 * std::numbers::pi * static_cast<double>(bin) / kBins;
    directions_[bin] = {std::cos(bearing), side * std::sin(bearing)};
  }
}

void StuckScanDetector::Likeness::add(float before, float now) {
  compared += before > 0.0F && now > 0.0F;
  equal += before > 0.0F && before == now;
}

void StuckScanDetector::add(const LaserScan& scan, std::span<const float> codes) {
  Likeness to_last, to_begin;
  newest_.fill(0.0F);
  for (const Beam& beam : scan.beams()) {
    if (!scan.isReturn(beam) || !std::isfinite(beam.bearing)) continue;
    if (std::find(codes.begin(), codes.end(), beam.range) != codes.end()) continue;
    const std::size_t bin = bearingBin(beam.bearing, kBins);
    to_last.add(seen_[bin], beam.range);
    to_begin.add(begin_[bin], beam.range);
    seen_[bin] = newest_[bin] = beam.range;
  }
  is_repeat_ = to_last.compared >= config_.fewest && to_last.equal == to_last.compared;
  is_like_begin_ = to_begin.compared >= config_.fewest && to_begin.equal > config_.by_chance * to_begin.compared;
}

bool StuckScanDetector::isStuck(const std::optional<Pose2>& T_odom_lidar) {
  const bool was_stuck = std::exchange(stuck_, stuck_ && is_like_begin_);
  if (was_stuck && stuck_) return true;
  if (!is_like_begin_) {
    begin(T_odom_lidar);
    return was_stuck;  // the turn in which it ends is old in part
  }
  ++repeats_;
  if (!T_odom_lidar || !T_odom_begin_) {
    T_odom_begin_ = T_odom_lidar;
    return false;
  }
  const Pose2 T_now_begin = between(*T_odom_lidar, *T_odom_begin_);
  stuck_ = repeats_ >= config_.stuck_turns && contradicts(T_now_begin);
  if (!stuck_ && T_now_begin.translation().norm() > config_.furthest) begin(T_odom_lidar);
  return stuck_;
}

void StuckScanDetector::begin(const std::optional<Pose2>& T_odom_lidar) {
  begin_ = newest_;
  T_odom_begin_ = T_odom_lidar;
  repeats_ = 0;
}

/// Whether ranges stayed as they were where the motion must have changed them. Where they changed, the lidar has
/// measured since, and may be stuck from the newest turn on.
bool StuckScanDetector::contradicts(const Pose2& T_now_begin) {
  const PointTransform moved(T_now_begin);
  vertices_ = 0;
  std::size_t last_bin = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (begin_[bin] == 0.0F) continue;
    const bool gap =
        vertices_ == 0 || static_cast<double>(bin - last_bin) * 2.0 * std::numbers::pi / kBins > config_.gap;
    if (gap && vertices_ > 0) line_[vertices_ - 1].last = true;
    line_[vertices_++] = {moved * (static_cast<double>(begin_[bin]) * directions_[bin]), gap, false};
    last_bin = bin;
  }
  if (vertices_ == 0) return false;
  line_[vertices_ - 1].last = true;

  const double rounding = config_.steps * step();
  Likeness left;
  const std::size_t every = 1 + vertices_ / config_.looked_at;
  std::size_t vertex = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (begin_[bin] == 0.0F || vertex++ % every != 0 || newest_[bin] == 0.0F) continue;
    const double range = static_cast<double>(begin_[bin]);
    const double tolerance = rounding + config_.place_error + config_.heading_error * range;
    if (hasLeft(range * directions_[bin], vertex - 1, tolerance)) left.add(begin_[bin], newest_[bin]);
  }
  if (left.compared < config_.must_change) return false;
  const bool unchanged = left.equal >= config_.by_chance * left.compared;
  if (!unchanged) begin(*T_odom_begin_ * T_now_begin.inverse());
  return unchanged;
}

/// Whether nothing that was seen is at a point any more. @param vertex of the line that was there: looked at first
bool StuckScanDetector::hasLeft(const Eigen::Vector2d& point, std::size_t vertex, double tolerance) const {
  double nearest = std::numeric_limits<double>::infinity();  // [m^2]
  bool open = false;                                         // the nearest is an end: the wall may go on from there
  for (std::size_t i = 0; i < vertices_; ++i) {
    const Vertex& to = line_[(vertex + i) % vertices_];
    Eigen::Vector2d at = to.position;
    bool at_end = to.first || to.last;
    if (!to.first) {
      const Eigen::Vector2d from = line_[(vertex + i + vertices_ - 1) % vertices_].position, way = to.position - from;
      const double share = way.squaredNorm() > 0.0 ? (point - from).dot(way) / way.squaredNorm() : 0.0;
      if (share < 1.0) at = from + std::max(share, 0.0) * way;
      at_end = share >= 1.0 && to.last;  // the beginning is a vertex of its own
    }
    const double distance = (point - at).squaredNorm();
    if (distance <= tolerance * tolerance) return false;
    if (distance < nearest || (distance == nearest && at_end)) {
      nearest = distance;
      open = at_end;
    }
  }
  return !open;
}

/// Of the ranges: the least between neighbours. [m]
double StuckScanDetector::step() const {
  float step = std::numeric_limits<float>::infinity(), last = 0.0F;
  for (const float range : begin_) {
    if (range == 0.0F) continue;
    const float difference = std::abs(range - last);
    if (last > 0.0F && difference > 1e-5F) step = std::min(step, difference);  // less is left of decimal places
    last = range;
  }
  return std::isfinite(step) ? static_cast<double>(step) : 0.0;
}

}  // namespace slam
