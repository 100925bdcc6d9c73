// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_imu.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using can::xsens::Vector3;

constexpr Duration kTogether = 8ms;  // frames of one sample come right behind each other, the next sample 10 ms later
constexpr Duration kLate = 500ms;    // a sample time that differs more from what the arrival says is damage or a reset

Eigen::Vector3d toVector(const Vector3& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

}  // namespace

std::optional<ImuSample> CanImu::add(const can::Frame& frame, Timestamp arrival) {
  bool good = false;
  if (frame.id == can::xsens::kSampleTime) {
    const auto ticks = can::xsens::parseSampleTime(frame);
    good = ticks && begin(*ticks, arrival);
  } else if (frame.id == can::xsens::kRateOfTurn) {
    good = fill(&Group::rate, can::xsens::parseRateOfTurn(frame), arrival);
  } else if (frame.id == can::xsens::kAcceleration) {
    good = fill(&Group::acceleration, can::xsens::parseAcceleration(frame), arrival);
  } else {
    return std::nullopt;
  }
  if (!good) {
    ++rejects_;
    return std::nullopt;
  }
  return group_->rate && group_->acceleration ? finish() : std::nullopt;
}

bool CanImu::begin(std::uint32_t ticks, Timestamp arrival) {
  if (group_) ++rejects_;  // a sample that was never completed
  group_.reset();
  // One damaged sample time must not bend the clock: what does not follow has to come twice.
  auto ticks_then = ticks_;
  const Duration device = ticks_then.count(ticks) * Duration(can::xsens::kTickNanoseconds);
  const Duration offset = arrival.time_since_epoch() - device;
  const bool follows = device_ && std::chrono::abs((device - *device_) - (arrival - arrival_)) < kLate;
  const bool confirmed = candidate_ && std::chrono::abs(offset - *candidate_) < kLate;
  if (device_ && !follows && !confirmed) {
    candidate_ = offset;
    return false;
  }
  candidate_.reset();
  ticks_ = ticks_then;
  device_ = device;
  arrival_ = arrival;
  group_ = Group{clock_.stamp(device, arrival), arrival, {}, {}};
  return true;
}

bool CanImu::fill(std::optional<Vector3> Group::*part, const std::optional<Vector3>& value, Timestamp arrival) {
  if (!value || !group_) return false;
  if ((*group_).*part || arrival - group_->arrival > kTogether) {  // its own sample time was lost
    group_.reset();
    return false;
  }
  (*group_).*part = value;
  return true;
}

std::optional<ImuSample> CanImu::finish() {
  const Group group = *group_;
  group_.reset();
  if (!last_stamp_ || *group.rate != last_rate_ || *group.acceleration != last_acceleration_) changed_ = group.arrival;
  last_rate_ = *group.rate;
  last_acceleration_ = *group.acceleration;
  if (last_stamp_ && group.stamp <= *last_stamp_) {  // stamps never go back, not even when the unit begins anew
    ++rejects_;
    return std::nullopt;
  }
  last_stamp_ = group.stamp;
  ImuSample sample;
  sample.stamp = group.stamp;
  sample.gyro = R_base_imu_ * toVector(*group.rate);
  sample.accel = R_base_imu_ * toVector(*group.acceleration);
  return sample;
}

}  // namespace slam
