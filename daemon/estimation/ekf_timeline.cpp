// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/ekf_timeline.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/plausibility.hpp"
#include "core/pose_covariance.hpp"

namespace slam {

EkfTimeline::EkfTimeline(const EkfConfig& ekf_config, const EkfTimelineConfig& config)
    : ekf_config_(std::make_unique<const EkfConfig>(ekf_config)),
      config_(config),
      ring_(static_cast<std::size_t>(config.capacity), Entry{{}, ImuSample{}, Ekf(*ekf_config_)}),
      base_(*ekf_config_, {}, ekf_config.initial_pose) {}

UpdateResult EkfTimeline::add(const WheelSample& sample) {
  return isPlausible(sample) ? insert(sample.stamp, sample) : UpdateResult::kUseless;
}

UpdateResult EkfTimeline::add(const ImuSample& sample) {
  return isPlausible(sample) ? insert(sample.stamp, sample) : UpdateResult::kUseless;
}

UpdateResult EkfTimeline::add(const PoseMeasurement& measurement) {
  const bool finite = isFinite(measurement.T_map_base) && measurement.covariance.allFinite();
  return finite ? insert(measurement.stamp, measurement) : UpdateResult::kUseless;
}

void EkfTimeline::add(const GyroBias& bias) {
  if (started_) insert(newestStamp(), bias);
}

void EkfTimeline::loseGyro() {
  for (std::size_t i = 0; i < size_; ++i) {
    if (auto* imu = std::get_if<ImuSample>(&entry(i).sample)) imu->rate_known = false;
  }
  run(0);
}

void EkfTimeline::setPose(const Pose2& pose, const Eigen::Vector3d& sigma) {
  if (size_ > 0) base_ = entry(size_ - 1).after;
  base_.setPose(pose, sigma);
  size_ = 0;
}

void EkfTimeline::transform(const Pose2& T_new_old) {
  const Eigen::Matrix3d rotation = turning(T_new_old.theta);
  base_.transform(T_new_old);
  for (std::size_t i = 0; i < size_; ++i) {
    entry(i).after.transform(T_new_old);
    if (auto* pose = std::get_if<PoseMeasurement>(&entry(i).sample)) {
      pose->T_map_base = T_new_old * pose->T_map_base;
      pose->covariance = rotated(pose->covariance, T_new_old.theta);
      pose->directions = (rotation * pose->directions).eval();
      pose->sensitivity = (rotation * pose->sensitivity).eval();
    }
  }
}

UpdateResult EkfTimeline::insert(Timestamp stamp, const Sample& sample) {
  if (!started_) {
    base_ = Ekf(*ekf_config_, stamp, base_.pose());
    started_ = true;
  }
  if (stamp < base_.stamp()) {
    ++too_old_;
    return UpdateResult::kUseless;
  }
  makeRoom(std::max(stamp, newestStamp()));

  const auto key = std::tuple(stamp, sample.index());
  std::size_t place = size_;
  while (place > 0 && key < std::tuple(entry(place - 1).stamp, entry(place - 1).sample.index())) --place;
  if (place < size_) ++late_fused_;
  ++size_;
  for (std::size_t i = size_ - 1; i > place; --i) entry(i) = entry(i - 1);
  entry(place).stamp = stamp;
  entry(place).sample = sample;

  const std::size_t first = std::holds_alternative<WheelSample>(sample) ? joinIntervals(place) : place;
  run(first);
  return entry(first).result;
}

void EkfTimeline::makeRoom(Timestamp newest) {
  // The last wheel sample stays, however old: the next one is measured against it.
  while (size_ > 1 && toSeconds(newest - entry(0).stamp) > config_.window &&
         (!std::holds_alternative<WheelSample>(entry(0).sample) || wheelsFrom(1))) {
    popOldest();
  }
  if (size_ == ring_.size()) popOldest();
}

void EkfTimeline::popOldest() {
  base_ = entry(0).after;
  begin_ = (begin_ + 1) % ring_.size();
  --size_;
}

std::optional<std::size_t> EkfTimeline::wheelsBefore(std::size_t end) const {
  for (std::size_t i = end; i-- > 0;) {
    if (std::holds_alternative<WheelSample>(entry(i).sample)) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> EkfTimeline::wheelsFrom(std::size_t begin) const {
  for (std::size_t i = begin; i < size_; ++i) {
    if (std::holds_alternative<WheelSample>(entry(i).sample)) return i;
  }
  return std::nullopt;
}

/// The interval that ends at the wheel sample `end`, as far as the samples before it are kept.
std::optional<EkfTimeline::Interval> EkfTimeline::intervalBefore(std::size_t end) const {
  std::optional<Interval> interval;
  for (auto begin = wheelsBefore(end); begin; begin = wheelsBefore(end)) {
    interval = {*begin, interval ? interval->samples + 1 : 1};
    if (!entry(end).joined) break;
    end = *begin;
  }
  return interval;
}

bool EkfTimeline::cameTooSoon(std::size_t i) const {
  const auto restarted = [&](std::size_t k) { return std::get<WheelSample>(entry(k).sample).restarted; };
  const auto previous = wheelsBefore(i);
  const auto before = previous ? intervalBefore(*previous) : std::nullopt;
  if (!before || restarted(i) || restarted(*previous)) return false;
  const double mean = toSeconds(entry(*previous).stamp - entry(before->begin).stamp) / before->samples;
  return toSeconds(entry(i).stamp - entry(*previous).stamp) < std::min(config_.jitter, config_.too_soon * mean);
}

/// Joins the wheels' intervals anew from the wheel sample `from` on. @return where the interval begins that it
/// completes
std::size_t EkfTimeline::joinIntervals(std::size_t from) {
  for (auto i = std::optional(from); i; i = wheelsFrom(*i + 1)) entry(*i).joined = cameTooSoon(*i);
  const auto interval = intervalBefore(from);
  return interval ? interval->begin : from;
}

/// @return last wheel sample of the interval that begins at `begin`; none: no interval begins there, or none ended yet
std::optional<std::size_t> EkfTimeline::intervalFrom(std::size_t begin) const {
  auto end = wheelsFrom(begin + 1);
  if (!end || entry(*end).joined) return std::nullopt;
  for (auto next = wheelsFrom(*end + 1); next && entry(*next).joined; next = wheelsFrom(*next + 1)) end = next;
  return end;
}

void EkfTimeline::run(std::size_t first) {
  for (std::size_t i = first; i < size_; ++i) {
    Ekf ekf = i == 0 ? base_ : entry(i - 1).after;
    ekf.predict(entry(i).stamp);
    entry(i).result = apply(i, ekf);
    entry(i).after = ekf;
  }
}

Twist2 EkfTimeline::meanTwist(std::size_t begin, std::size_t end) const {
  const auto &from = std::get<WheelSample>(entry(begin).sample), &to = std::get<WheelSample>(entry(end).sample);
  const Eigen::Vector3d travel = log(between(from.T_wheels_base, to.T_wheels_base)) / toSeconds(to.stamp - from.stamp);
  return {travel.x(), travel.y(), travel.z()};
}

/// Mean twist of the wheels over the last `recent` seconds before the newest sample; none where that is one interval
/// only, or where they have just stopped, which no stamp can feign.
std::optional<Twist2> EkfTimeline::recentTwist(std::size_t end) const {
  const auto restarted = [&](std::size_t i) { return std::get<WheelSample>(entry(i).sample).restarted; };
  const auto seconds = [&](std::size_t begin) { return toSeconds(entry(end).stamp - entry(begin).stamp); };
  const auto last = intervalBefore(end);
  if (!last || restarted(end) || !(seconds(last->begin) > 0.0)) return std::nullopt;
  const Twist2 now = meanTwist(last->begin, end);
  const double turn_rate = std::get<WheelSample>(entry(end).sample).turn_rate_known ? now.omega : 0.0;
  if (ekf_config_->standstill.isQuiet(std::hypot(now.vx, now.vy), turn_rate)) return std::nullopt;
  std::size_t begin = last->begin;
  while (seconds(begin) < config_.recent && !restarted(begin)) {
    const auto before = wheelsBefore(begin);
    if (!before || seconds(*before) > 2.0 * config_.recent) break;
    begin = *before;
  }
  if (begin == last->begin) return std::nullopt;
  return meanTwist(begin, end);
}

UpdateResult EkfTimeline::apply(std::size_t i, Ekf& ekf) const {
  if (const auto* pose = std::get_if<PoseMeasurement>(&entry(i).sample)) return ekf.updatePose(*pose);
  if (const auto* imu = std::get_if<ImuSample>(&entry(i).sample)) {
    if (imu->rate_known) return ekf.updateGyro(imu->gyro.z());
    ekf.loseGyro();
    return UpdateResult::kUseless;
  }

  if (const auto* bias = std::get_if<GyroBias>(&entry(i).sample)) {
    ekf.setGyroBias(bias->value, bias->variance);
    return UpdateResult::kFused;
  }

  const auto end = intervalFrom(i);
  if (!end) {
    const auto twist = wheelsFrom(i + 1) ? std::nullopt : recentTwist(i);
    if (twist) ekf.holdTwist(*twist, std::get<WheelSample>(entry(i).sample).turn_rate_known);
    return UpdateResult::kUseless;
  }
  const auto& from = std::get<WheelSample>(entry(i).sample);
  const auto& to = std::get<WheelSample>(entry(*end).sample);
  const Duration interval = to.stamp - from.stamp;
  if (to.restarted || interval <= Duration::zero()) return UpdateResult::kUseless;

  double gyro_sum = 0.0;
  int gyro_count = 0;
  bool gyro_known = true;
  for (std::size_t j = i + 1; j < *end; ++j) {
    if (const auto* imu = std::get_if<ImuSample>(&entry(j).sample)) {
      gyro_known &= imu->rate_known;
      gyro_sum += imu->gyro.z();
      ++gyro_count;
    }
  }
  return ekf.updateWheels(meanTwist(i, *end), to.turn_rate_known, interval,
                          gyro_count > 0 && gyro_known ? std::optional(gyro_sum / gyro_count) : std::nullopt);
}

const Ekf& EkfTimeline::upTo(Timestamp stamp) const {
  std::size_t i = size_;
  while (i > 0 && entry(i - 1).stamp > stamp) --i;
  return i == 0 ? base_ : entry(i - 1).after;
}

Ekf EkfTimeline::at(Timestamp stamp) const {
  Ekf ekf = upTo(stamp);
  ekf.predict(stamp);
  return ekf;
}

void EkfTimeline::fillHistory(Timestamp from, Timestamp to, PoseHistory& history) const {
  history.clear();
  history.push(from, poseAt(from));
  std::size_t i = size_;
  while (i > 0 && entry(i - 1).stamp > from) --i;
  for (; i < size_ && entry(i).stamp < to; ++i) history.push(entry(i).stamp, entry(i).after.pose());
  history.push(to, poseAt(to));
}

}  // namespace slam
