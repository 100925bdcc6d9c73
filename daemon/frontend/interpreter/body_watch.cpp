// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/body_watch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "frontend/interpreter/bearing_bins.hpp"

namespace slam {
namespace {

double radiansPerBin() { return std::numbers::pi / 360.0; }

}  // namespace

BodyWatch::BodyWatch(const LidarModel& lidar, const BodyWatchConfig& config)
    : config_(config),
      T_base_lidar_(lidar.T_base_lidar),
      side_(lidar.upside_down ? -1.0 : 1.0),
      tolerance_(config.same_range * lidar.range_sigma) {
  for (int bin = 0; bin < bins(); ++bin) {
    const double bearing = bin * radiansPerBin();
    directions_[static_cast<std::size_t>(bin)] = {std::cos(bearing), side_ * std::sin(bearing)};
  }
}

int BodyWatch::binOf(double bearing) const {
  return static_cast<int>(bearingBin(bearing, static_cast<std::size_t>(bins())));
}

Eigen::Vector2d BodyWatch::pointAt(int bin, float range) const {
  return range * directions_[static_cast<std::size_t>(bin)];
}

bool BodyWatch::isSame(float range, const Ranges& seen, int bin) const {
  const float here = seen[static_cast<std::size_t>(bin)];
  if (here == 0.0F) return false;
  float least = here, most = here;
  for (const int beside : {-2, -1, 1, 2}) {
    const float there = seen[static_cast<std::size_t>(wrapped(bin + beside))];
    if (std::abs(there - here) > config_.slope * here) continue;
    least = std::min(least, there);
    most = std::max(most, there);
  }
  const double near = tolerance_;
  return range > least - near && range < most + near;
}

std::optional<int> BodyWatch::sight(const Ranges& ranges, const Eigen::Vector2d& point) const {
  const double distance = point.norm(), near = tolerance_;
  if (distance < config_.place_error) return std::nullopt;
  const int bin = binOf(side_ * std::atan2(point.y(), point.x()));
  const int reach = spacing_ + static_cast<int>(config_.place_error / distance / radiansPerBin());
  std::optional<int> sight;
  for (int k = -reach; k <= reach; ++k) {
    const float range = ranges[static_cast<std::size_t>(wrapped(bin + k))];
    if (range == 0.0F) continue;
    const int here = range < distance - near ? -1 : range > distance + near ? 1 : 0;
    if (here == 0) return 0;
    sight = std::min(sight.value_or(1), here);
  }
  return sight;
}

void BodyWatch::add(std::span<const Beam> beams, const RangeLimits& limits, const Pose2& T_odom_base) {
  const Pose2 lidar = T_odom_base * T_base_lidar_;
  if (seen_from_) {
    const Pose2 moved = between(*seen_from_, lidar);
    if (std::hypot(moved.x, moved.y) < config_.translation && std::abs(moved.theta) < config_.rotation) return;
  }
  spacing_ = std::max(2, bins() / std::max(1, static_cast<int>(beams.size())) + 1);
  shortestRanges(beams, limits, now_);
  if (seen_from_)
    update(compare(PointTransform(between(*seen_from_, lidar)), PointTransform(between(lidar, *seen_from_))));
  seen_from_ = lidar;
  seen_ = now_;
}

bool BodyWatch::compare(const PointTransform& T_seen_now, const PointTransform& T_now_seen) {
  int stayed = 0, moved = 0, changed = 0;
  for (int bin = 0; bin < bins(); ++bin) {
    const auto i = static_cast<std::size_t>(bin);
    stayed_[i] = false;
    if (now_[i] == 0.0F) continue;
    const auto before = sight(seen_, T_seen_now * pointAt(bin, now_[i]));
    if (isSame(now_[i], seen_, bin)) {
      const auto after = sight(now_, T_now_seen * pointAt(bin, seen_[i]));
      stayed_[i] = (before == 1 || after == 1) && before != 0 && after != 0;
      stayed += stayed_[i];
    } else {
      moved += before == 0;
      changed += before.has_value();
    }
  }
  return moved > config_.few_moved * stayed && moved > config_.explained * changed;
}

void BodyWatch::update(bool moved) {
  shape_ = left_out_ = {};
  for (int bin = 0; bin < bins(); ++bin) {
    const auto i = static_cast<std::size_t>(bin);
    std::int8_t& steps = steps_[i];
    if (moved && stayed_[i]) {
      if (steps == 0 || !isSame(now_[i], body_, bin)) {
        steps = 0;
        body_[i] = seen_[i];
      }
      body_[i] += static_cast<float>(config_.follow) * (now_[i] - body_[i]);
      steps = static_cast<std::int8_t>(std::min(config_.sure, steps + (allStayedAround(bin) ? config_.enough : 1)));
    } else if (steps > 0 && now_[i] > body_[i] + tolerance_) {
      steps = static_cast<std::int8_t>(std::max(0, steps - config_.passed));
    }
    if (steps < config_.enough) continue;
    const auto range = static_cast<std::uint16_t>(std::lround(1000.0F * body_[i]));
    left_out_.millimetres[i / 2] = range;
    if (steps >= config_.sure) shape_.millimetres[i / 2] = range;
  }
}

bool BodyWatch::allStayedAround(int bin) const {
  int seen = 0, stayed = 0;
  for (int k = -config_.around; k <= config_.around; ++k) {
    const auto i = static_cast<std::size_t>(wrapped(bin + k));
    seen += now_[i] > 0.0F;
    stayed += stayed_[i];
  }
  return seen >= config_.around && stayed >= config_.most_around * seen;
}

bool BodyWatch::isBody(const Beam& beam) const {
  const int bin = binOf(beam.bearing);
  for (int k = -2; k <= 2; ++k) {
    const auto i = static_cast<std::size_t>(wrapped(bin + k));
    if (steps_[i] >= config_.enough && isSame(beam.range, body_, wrapped(bin + k))) return true;
  }
  return false;
}

void BodyWatch::begin(const BodyShape& shape) {
  for (std::size_t i = 0; i < bins(); ++i) {
    const std::uint16_t range = shape.millimetres[i / 2];
    if (range == 0) continue;
    body_[i] = 0.001F * range;
    steps_[i] = static_cast<std::int8_t>(config_.sure);
  }
  shape_ = left_out_ = shape;
}

}  // namespace slam
