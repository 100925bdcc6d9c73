// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/no_return_watch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace slam {
namespace {

std::int8_t directionOf(float bearing) {
  const double turns = static_cast<double>(bearing) / (2.0 * std::numbers::pi);
  return static_cast<std::int8_t>(std::min(63.0, 64.0 * (turns - std::floor(turns))));
}

}  // namespace

void NoReturnWatch::add(std::span<const Beam> beams, const RangeLimits& limits,
                        const std::optional<Eigen::Vector2d>& lidar) {
  if (begun_ && (!lidar || (last_ && (*lidar - *last_).norm() < config_.translation))) return;
  begun_ = true;
  last_ = lidar;
  std::size_t size = 0;
  for (const Beam& beam : beams) {
    if (!limits.contains(beam.range) || !std::isfinite(beam.bearing) || isCode(beam.range)) continue;
    samples_[size++] = {beam.range, directionOf(beam.bearing)};
  }
  std::sort(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(size),
            [](const Sample& a, const Sample& b) { return a.range > b.range; });
  countCandidates({samples_.data(), size});
}

/// From the largest range down, as long as it is the rim.
void NoReturnWatch::countCandidates(std::span<const Sample> samples) {
  const auto all = static_cast<double>(samples.size());
  std::size_t above = 0;
  for (std::size_t begin = 0, end = 0; begin < samples.size() && static_cast<double>(above) <= config_.above * all;
       begin = end) {
    const float value = samples[begin].range;
    std::uint64_t directions = 0;
    for (; end < samples.size() && samples[end].range > value - config_.step; ++end)
      directions |= std::uint64_t{1} << samples[end].direction;
    const std::size_t count_here = end - begin;
    std::size_t near = 0, values = 0;
    float last = value;
    for (std::size_t i = end; i < samples.size() && samples[i].range > 0.5F * value; ++i) {
      values += samples[i].range < last - config_.step;
      last = std::min(last, samples[i].range);
      ++near;
    }
    const int spread = std::popcount(directions);
    const bool shared = static_cast<int>(count_here) >= config_.fewest && spread >= config_.directions &&
                        static_cast<double>(count_here * values) >= config_.over_others * static_cast<double>(near);
    if (shared) {
      count(value, spread >= config_.wide ? config_.places : 1);
    } else {
      above += count_here;
    }
  }
}

void NoReturnWatch::count(float value, int places) {
  Candidate* candidate = std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& c) {
    return c.places > 0 && std::abs(c.value - value) <= config_.step;
  });
  if (candidate == candidates_.end()) {
    candidate = &candidates_[next_++ % candidates_.size()];
    *candidate = {value, 0};
  }
  candidate->places += places;
  if (candidate->places < config_.places || found_ == codes_.size() || isCode(value)) return;
  codes_[found_++] = candidate->value;
}

bool NoReturnWatch::isCode(float range) const {
  return std::any_of(codes_.begin(), codes_.begin() + static_cast<std::ptrdiff_t>(found_),
                     [&](float code) { return std::abs(range - code) <= config_.step; });
}

}  // namespace slam
