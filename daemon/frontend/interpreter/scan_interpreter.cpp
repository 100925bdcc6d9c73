// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/scan_interpreter.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
ScanInterpreter::ScanInterpreter(const InterpreterConfig& config, const LidarModel& lidar, const BodyShape& body)
    : lidar_(lidar),
      sweep_(lidar_.upside_down, config.sweep),
      codes_(config.no_return),
      body_(lidar_, config.body),
      noise_(config.range_noise),
      cabin_(config.cabin),
      several_floors_(config.several_floors) {
  body_.begin(body);
}

const LaserScan& ScanInterpreter::interpret(const LaserScan& recorded, Timestamp first, double interval,
                                            const EkfTimeline& odometry) {
  scan_.stamp = recorded.stamp;
  scan_.range_min = recorded.range_min;
  scan_.range_max = recorded.range_max;
  scan_.size = 0;
  for (const Beam& beam : recorded.beams()) scan_.push(beam);
  giveTimes(first, interval, odometry);

  const RangeLimits limits = lidar_.limitsFor(scan_);
  const std::span<Beam> beams(scan_.storage.data(), static_cast<std::size_t>(scan_.size));
  std::optional<Ekf> middle;
  if (odometry.started()) {
    const double last = beams.empty() ? 0.0 : beams.back().time_offset;
    middle = odometry.at(first + fromSeconds(0.5 * last));
  }
  codes_.add(beams, limits,
             middle ? std::optional((middle->pose() * lidar_.T_base_lidar).translation()) : std::nullopt);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    Beam& beam = beams[i];
    const bool masked = isMasked(beam), code = codes_.isCode(beam.range);
    open_[i] = !masked && (code || !(beam.range > 0.0F) || beam.range > limits.max);
    if (code || masked) beam.range = 0.0F;
  }
  if (!middle) return scan_;
  body_.add(beams, limits, middle->pose());
  if (leftOut().degrees() > 0) {
    for (Beam& beam : beams) {
      if (body_.isBody(beam)) beam.range = 0.0F;
    }
  }
  if (several_floors_) cabin_.add(beams, limits, middle->pose(), first);
  noise_.add(beams, limits, middle->standstill());
  if (noise_.tooNoisy()) {
    for (Beam& beam : beams) beam.range = 0.0F;
    open_.fill(false);
  }
  return scan_;
}

void ScanInterpreter::giveTimes(Timestamp first, double interval, const EkfTimeline& odometry) {
  const std::span<Beam> beams(scan_.storage.data(), static_cast<std::size_t>(scan_.size));
  const bool timed = std::any_of(beams.begin(), beams.end(), [](const Beam& beam) { return beam.time_offset != 0.0F; });
  if (timed || interval <= 0.0 || !odometry.started()) return;
  const double sweep = SweepWatch::sweepOf(beams) * interval;
  const Ekf begin = odometry.at(first);
  if (begin.gyroActive()) {
    const Pose2 end = odometry.poseAt(first + fromSeconds(interval));
    sweep_.add(beams, lidar_.limitsFor(scan_), first, interval,
               {begin.pose() * lidar_.T_base_lidar, end * lidar_.T_base_lidar});
  }
  if (!timesMissing()) return;
  const bool forward = sweep_.order() == SweepWatch::Order::kForward;
  const double each = sweep / static_cast<double>(beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i)
    beams[i].time_offset = static_cast<float>(each * static_cast<double>(forward ? i : beams.size() - 1 - i));
}

bool ScanInterpreter::isMasked(const Beam& beam) const {
  return std::any_of(lidar_.mask.begin(), lidar_.mask.end(), [&](const BearingRange& masked) {
    const double beyond = beam.bearing * 180.0 / std::numbers::pi - masked.from;
    return beyond - 360.0 * std::floor(beyond / 360.0) <= masked.to - masked.from;
  });
}

}  // namespace slam
