// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/gyro_monitor.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace slam {
namespace {

struct Range {
  double low = 0.0, high = 0.0;
  double size() const { return std::max(std::abs(low), std::abs(high)); }
};

}  // namespace

GyroMonitor::GyroMonitor(const EkfConfig& noise, const GyroMonitorConfig& config)
    : noise_(noise), config_(config), gyro_(1024), wheels_(1024) {
  begin(false);
}

void GyroMonitor::begin(bool rejected) {
  rejected_ = rejected;
  against_ = rejected ? 1.0 : 0.0;
  votes_ = rejected ? 1 : 0;
  if (!rejected) return;
  proofs_ = 0;
  ++rejections_;
}

void GyroMonitor::forget() {
  begin(false);
  interrupt();
  information_.setZero();
  gradient_.setZero();
}

ImuSample GyroMonitor::add(const ImuSample& sample) {
  has_samples_ = true;
  ImuSample assessed = sample;
  const double rate = sample.gyro.z(), size = std::abs(rate);
  if (!std::isfinite(rate)) return assessed;
  const bool repeats = size == largest_;
  if (size > largest_) {
    largest_ = size;
    repeated_ = 0;
    clipped_ = false;
  }
  repeated_ += repeats;
  assessed.rate_known = !rejected_ && !(clipped_ && repeats);

  Pose2 turned;
  if (!gyro_.empty()) {
    const double interval = toSeconds(sample.stamp - gyro_.newest().stamp);
    if (interval > noise_.gyro_timeout || interval < -noise_.gyro_timeout) {
      gyro_.clear();
      interrupt();
    } else {
      turned = gyro_.newest().pose;
      turned.x += 0.5 * interval * (last_rate_ + rate);
      turned.y += repeats ? interval : 0.0;
    }
  }
  if (gyro_.push(sample.stamp, turned)) last_rate_ = rate;
  return assessed;
}

bool GyroMonitor::add(const WheelSample& sample, double bias) {
  const double theta = sample.T_wheels_base.theta;
  if (!sample.turn_rate_known || !std::isfinite(theta)) return false;
  const bool set_back = !wheels_.empty() && sample.stamp < wheels_.newest().stamp - fromSeconds(noise_.long_silence);
  if (sample.restarted || set_back) {
    wheels_.clear();
    interrupt();
  }
  const double since_begin =
      wheels_.empty() ? 0.0 : wheels_.newest().pose.x + wrapAngle(theta - last_wheels_.value_or(theta));
  if (!wheels_.push(sample.stamp, {since_begin, 0.0, 0.0})) return false;
  last_wheels_ = theta;
  if (proofs_ >= config_.least || rejected_) return false;

  // Either may lag behind the other.
  const Duration lag = fromSeconds(config_.beyond), window = fromSeconds(noise_.slip_window);
  const auto turns = [&](const PoseHistory& sensor, double offset) -> std::optional<Range> {
    std::array<double, 2> turn{};
    for (std::size_t i = 0; i < 2; ++i) {
      const Timestamp end = sample.stamp - static_cast<int>(i) * lag;
      const auto measured = turned(sensor, end - window, end);
      if (!measured) return std::nullopt;
      turn[i] = *measured - offset * noise_.slip_window;
    }
    return Range{std::min(turn[0], turn[1]), std::max(turn[0], turn[1])};
  };
  const auto gyro = turns(gyro_, bias), wheels = turns(wheels_, 0.0);
  if (!gyro || !wheels) return false;
  if (wheels->size() < noise_.standstill.max_turn_rate * noise_.slip_window) return false;  // the filter rests
  // Wheels may spin where nothing turns; a robot seldom turns with wheels that do not.
  const double low = std::min(0.0, wheels->low), high = std::max(0.0, wheels->high);
  const double apart = std::max(gyro->low - high, low - gyro->high);
  if (apart <= noise_.slip_angle + noise_.slip_scale * wheels->size()) return false;
  begin(true);
  return true;
}

std::optional<GyroMonitor::Instant> GyroMonitor::at(Timestamp stamp, double theta) const {
  const Duration beyond = fromSeconds(config_.beyond);
  const auto gyro = gyro_.at(stamp, beyond), wheels = wheels_.at(stamp, beyond);
  if (!gyro) return std::nullopt;
  return Instant{stamp, {0.0, theta, gyro->x, gyro->y, wheels ? std::optional(wheels->x) : std::nullopt}};
}

std::optional<GyroBias> GyroMonitor::compare(Timestamp stamp, double theta, double bias) {
  const auto end = at(stamp, theta);
  if (!end || !begin_) {
    begin_ = end;
    return std::nullopt;
  }
  Turn turn{toSeconds(stamp - begin_->stamp), wrapAngle(end->turn.scans - begin_->turn.scans),
            end->turn.gyro - begin_->turn.gyro, end->turn.pinned - begin_->turn.pinned, std::nullopt};
  if (end->turn.wheels && begin_->turn.wheels) turn.wheels = *end->turn.wheels - *begin_->turn.wheels;
  const double most = std::max({std::abs(turn.scans), std::abs(turn.gyro), std::abs(turn.wheels.value_or(0.0))});
  if (most < config_.interval && turn.seconds < config_.longest) return std::nullopt;
  begin_ = end;
  if (!(turn.seconds > 0.0)) return std::nullopt;
  learnRange(turn, bias);
  if (clipped_ && turn.pinned > 0.0) return std::nullopt;
  learnRelation(turn);
  return vote(turn, bias);
}

std::optional<double> GyroMonitor::turned(Timestamp from, Timestamp to) const {
  return rejected_ ? std::nullopt : turned(gyro_, from, to);
}

std::optional<double> GyroMonitor::turned(const PoseHistory& sensor, Timestamp from, Timestamp to) const {
  const auto a = sensor.at(from, fromSeconds(config_.beyond)), b = sensor.at(to, fromSeconds(config_.beyond));
  if (!a || !b || (clipped_ && b->y > a->y)) return std::nullopt;
  return b->x - a->x;
}

void GyroMonitor::learnRange(const Turn& turn, double bias) {
  if (clipped_ || repeated_ < config_.least || turn.pinned < 0.5 * turn.seconds) return;
  const double wheels = turn.wheels.value_or(turn.scans), by_gyro = turn.gyro - bias * turn.seconds;
  if (std::abs(wheels - turn.scans) > std::abs(by_gyro - turn.scans)) return;
  clipped_ = std::abs(turn.scans) > std::abs(by_gyro) + config_.scan_turn;
  if (clipped_) begin(false);  // what it read at the end of its range is no reason any more
}

void GyroMonitor::learnRelation(const Turn& turn) {
  const Eigen::Vector2d row(turn.scans, turn.seconds);
  const double fade = 1.0 - 1.0 / config_.memory;
  information_ = fade * information_ + row * row.transpose();
  gradient_ = fade * gradient_ + row * turn.gyro;
}

std::optional<GyroBias> GyroMonitor::vote(const Turn& turn, double bias) {
  const double known = rejected_ ? offset() : bias;
  const double error = std::abs(turn.gyro - known * turn.seconds - turn.scans);
  const double others = turn.wheels ? std::abs(*turn.wheels - turn.scans) : std::abs(turn.scans);
  const bool against = error > config_.worse * others + config_.scan_turn;
  const bool at_rest = std::abs(turn.scans) < config_.interval;
  if (!against && at_rest && rejected_) return std::nullopt;  // there gyros of any scale and sign agree
  votes_ = std::min(votes_ + 1, static_cast<int>(config_.memory));
  against_ += ((against ? 1.0 : 0.0) - against_) / votes_;
  if (proofs_ < config_.least && (against || !at_rest)) proofs_ = against ? 0 : proofs_ + 1;
  if (votes_ < config_.least) return std::nullopt;
  if (!rejected_ && against_ > config_.rejected) {
    begin(true);
  } else if (rejected_ && against_ < config_.agreement) {
    rejected_ = false;
    return GyroBias{offset(), noise_.initial_gyro_bias_sigma * noise_.initial_gyro_bias_sigma};
  }
  return std::nullopt;
}

Eigen::Vector2d GyroMonitor::relation() const {
  const double prior = config_.scan_turn * config_.scan_turn / (config_.prior_sigma * config_.prior_sigma);
  return (information_ + prior * Eigen::Matrix2d::Identity()).inverse() *
         (gradient_ + prior * Eigen::Vector2d::UnitX());
}

double GyroMonitor::offset() const {
  return std::clamp(relation().y(), -noise_.largest_gyro_bias, noise_.largest_gyro_bias);
}

GyroVerdict GyroMonitor::verdict(double bias) const {
  if (!has_samples_) return {};
  GyroVerdict verdict{rejected_                 ? GyroReliability::kRejected
                      : proofs_ < config_.least ? GyroReliability::kUnproven
                                                : GyroReliability::kReliable};
  const auto because = [&](GyroFault fault, double value) {
    verdict.fault = fault;
    verdict.value = value;
    return verdict;
  };
  if (!rejected_) {
    if (clipped_) return because(GyroFault::kClipped, largest_);
    return std::abs(bias) > config_.large_offset ? because(GyroFault::kOffset, bias) : verdict;
  }
  if (votes_ < config_.least || against_ < config_.rejected) return verdict;  // the scans have not decided yet
  const double scale = relation().x(), rate = relation().y();
  const auto near = [&](double value) { return std::abs(scale / value - 1.0) < config_.off_scale; };
  if (near(-1.0)) return because(GyroFault::kReversed, scale);
  if (near(180.0 / std::numbers::pi)) return because(GyroFault::kDegrees, scale);
  if (near(1.0) && std::abs(rate) > config_.large_offset) return because(GyroFault::kOffset, rate);
  return near(1.0) ? because(GyroFault::kUnrelated, scale) : because(GyroFault::kScale, scale);
}

}  // namespace slam
