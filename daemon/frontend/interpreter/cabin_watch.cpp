// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/cabin_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace slam {

CabinWatch::View CabinWatch::viewOf(std::span<const Beam> beams, const RangeLimits& limits) const {
  const double whole = 2.0 * std::numbers::pi;                // [rad] turn
  const auto gapOf = [whole](const Beam& a, const Beam& b) {  // less than a turn is between two bearings
    const double gap = std::abs(static_cast<double>(b.bearing) - a.bearing);
    return gap > 0.5 * whole ? whole - gap : gap;
  };
  View view;
  if (beams.size() < 2) return view;
  const Beam *first = nullptr, *last = nullptr;
  const auto join = [&](const Beam& a, const Beam& b) {
    const double gap = gapOf(a, b);
    if (gap > config_.widest_gap) return;
    view.seen += gap;
    view.area += 0.5 * a.range * b.range * gap;  // a triangle: the sine of so small an angle is the angle
  };
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Beam& beam = beams[i];
    if (i > 0) view.field += gapOf(beams[i - 1], beam);
    if (!(beam.range > limits.min) || beam.range > limits.max) continue;
    last != nullptr ? join(*last, beam) : void(first = &beam);
    last = &beam;
  }
  const double step = view.field / static_cast<double>(beams.size() - 1);
  if (whole - view.field < 2.0 * step) view.field = whole;  // from the last beam to the first, too
  if (first != nullptr && view.field == whole) join(*last, *first);
  if (view.seen > 0.0) view.area *= whole / view.seen;
  return view;
}

void CabinWatch::add(std::span<const Beam> beams, const RangeLimits& limits, const Pose2& T_odom_base, Timestamp now) {
  opened_ = false;
  const View view = viewOf(beams, limits);
  const bool known = view.field > 0.0 && view.seen >= config_.seen * view.field;
  const double area = known ? view.area : std::numeric_limits<double>::infinity();
  if (shut_) {
    opened_ = known && config_.shut * area > cabin_;
    if (!opened_) return;
    shut_ = false;
    widest_ = 0.0;
  }
  const Pose2 moved = between(at_, T_odom_base);
  const bool turned = std::abs(moved.theta) > config_.turned && view.field < config_.all_around;
  if (turned || moved.translation().norm() > config_.moved) widest_ = 0.0;
  if (widest_ == 0.0) {
    at_ = T_odom_base;
    shut_since_.reset();
  }
  widest_ = std::max(widest_, area);
  if (area > std::min(config_.largest, config_.shut * widest_)) return shut_since_.reset();
  if (!shut_since_) shut_since_ = now, cabin_ = 0.0;
  cabin_ = std::max(cabin_, area);
  shut_ = now - *shut_since_ >= config_.shut_for;
}

}  // namespace slam
