// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_imu.hpp"

#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;
using can::xsens::Vector3;

constexpr Duration kTogether = 8ms;  // frames of one sample come right behind each other, the next sample 10 ms later
constexpr Duration kImuSilent = 500ms;  // frames come every 10 ms
constexpr Duration kFrozen = 1s;        // noise changes the values every few samples
constexpr Duration kLate = 500ms;  // a sample time that differs more from what the arrival says is damage or a reset

Eigen::Vector3d toVector(const Vector3& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

}  // namespace

std::optional<ImuSample> CanImu::reject() {
  ++rejects_;
  return std::nullopt;
}

std::optional<ImuSample> CanImu::add(const can::Frame& frame, Timestamp arrival) {
  if (frame.id == can::xsens::kRateOfTurn) return addRate(can::xsens::parseRateOfTurn(frame), arrival);
  if (frame.id == can::xsens::kAcceleration) return addAcceleration(can::xsens::parseAcceleration(frame), arrival);
  if (frame.id != can::xsens::kSampleTime) return std::nullopt;
  time_came_ = true;
  const auto ticks = can::xsens::parseSampleTime(frame);
  return ticks && addTime(*ticks, arrival) ? std::nullopt : reject();
}

bool CanImu::addTime(std::uint32_t ticks, Timestamp arrival) {
  const bool unfinished = group_ && group_->rate.has_value() != group_->acceleration.has_value();
  if (unfinished && usesTime() && usesAcceleration()) ++rejects_;  // a sample that was never completed
  group_.reset();
  const std::optional<Timestamp> stamp = times_.stamp(ticks, arrival);
  if (stamp) group_ = Group{*stamp, arrival, {}, {}};
  return stamp.has_value();
}

std::optional<Timestamp> CanImu::SampleTimes::stamp(std::uint32_t ticks, Timestamp arrival) {
  auto ticks_then = ticks_;
  const Duration device = ticks_then.count(ticks) * Duration(can::xsens::kTickNanoseconds);
  const Duration offset = arrival.time_since_epoch() - device;
  const bool follows = device_ && std::chrono::abs((device - *device_) - (arrival - arrival_)) < kLate;
  const bool confirmed = candidate_ && std::chrono::abs(offset - *candidate_) < kLate;
  if (device_ && !follows && !confirmed) {
    candidate_ = offset;
    return std::nullopt;
  }
  candidate_.reset();
  ticks_ = ticks_then;
  device_ = device;
  arrival_ = arrival;
  return clock_.stamp(device, arrival);
}

std::optional<ImuSample> CanImu::addRate(const std::optional<Vector3>& rate, Timestamp arrival) {
  if (!rate) return reject();
  const bool timed = group_ && !group_->rate && arrival - group_->arrival <= kTogether;
  // A sample time that came damaged is none that the unit does not send.
  const bool damaged = std::exchange(time_came_, false) && !timed;
  if (!damaged) with_time_.note(timed);
  if (const auto before = std::exchange(accelerated_, std::nullopt)) with_acceleration_.note(*before);
  if (!timed) group_.reset();
  if (!timed && usesTime()) return reject();  // its own sample time was lost
  if (!usesTime()) group_ = Group{arrival, arrival, {}, group_ ? group_->acceleration : std::nullopt};
  group_->rate = rate;
  accelerated_ = group_->acceleration.has_value();
  return *accelerated_ || !usesAcceleration() ? make(*group_) : std::nullopt;
}

std::optional<ImuSample> CanImu::addAcceleration(const std::optional<Vector3>& acceleration, Timestamp arrival) {
  if (!acceleration) {
    accelerated_.reset();
    return reject();
  }
  if (!group_ || group_->acceleration || arrival - group_->arrival > kTogether) {
    const bool whole = group_ && group_->rate && group_->acceleration;
    group_.reset();
    return usesAcceleration() && !whole ? reject() : std::nullopt;
  }
  group_->acceleration = acceleration;
  if (!group_->rate) return std::nullopt;
  accelerated_ = true;
  return usesAcceleration() ? make(*group_) : std::nullopt;  // else its turn rate has been used already
}

std::optional<ImuSample> CanImu::make(const Group& group) {
  const bool accelerated = group.acceleration && group.acceleration != last_acceleration_;
  if (!last_stamp_ || *group.rate != last_rate_ || accelerated) changed_ = group.arrival;
  last_rate_ = *group.rate;
  if (group.acceleration) last_acceleration_ = *group.acceleration;
  if (last_stamp_ && group.stamp <= *last_stamp_) return reject();  // not even when the unit begins anew
  last_stamp_ = group.stamp;
  ImuSample sample;
  sample.stamp = group.stamp;
  sample.gyro = R_base_imu_ * toVector(*group.rate);
  if (group.acceleration) sample.accel = R_base_imu_ * toVector(*group.acceleration);
  return sample;
}

std::optional<ImuSample> CanImuUnit::add(const StampedCanFrame& received, Timestamp now) {
  if (received.frame.id == can::xsens::kSampleTime) last_time_ = received.stamp;
  if (received.frame.id == can::xsens::kRateOfTurn) last_rate_ = received.stamp;
  if (received.frame.id == can::xsens::kAcceleration) last_acceleration_ = received.stamp;
  const auto sample = imu_.add(received.frame, received.stamp);
  status_.rejects.store(imu_.rejects(), std::memory_order_relaxed);
  if (!sample || received.stamp - imu_.changed() > kFrozen) return std::nullopt;
  last_sample_ = now;
  status_.countSample(sample->stamp);
  return sample;
}

CanImuUnit::Finding CanImuUnit::look(const LinkSilence& silence, Timestamp now) const {
  const auto silent = [&](Timestamp frame) { return silence.since(frame, now, kImuSilent); };
  const bool no_time = silent(last_time_), no_rate = silent(last_rate_), no_acceleration = silent(last_acceleration_);
  if (no_time && no_rate && no_acceleration) return {DeviceState::kStale, problem::kCanNoImu};
  if (no_rate) return {DeviceState::kStale, problem::kCanNoRate};
  const bool some = silence.isFresh(last_sample_);
  if (!some && !silent({})) return {DeviceState::kOpening, {problem::kWaitsForFrames, {}, {"the IMU's"}}};
  if (some && !silent(last_sample_)) {
    return {DeviceState::kStreaming, no_time                    ? problem::kCanNoTime
                                     : no_acceleration          ? problem::kCanNoAcceleration
                                     : !imu_.usesTime()         ? problem::kCanRareTime
                                     : !imu_.usesAcceleration() ? problem::kCanRareAcceleration
                                                                : Problem()};
  }
  return {DeviceState::kStale, now - imu_.changed() > kFrozen ? problem::kCanImuFrozen : problem::kCanImuSenseless};
}

}  // namespace slam
