// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/base/counting_base.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {
namespace {

constexpr Duration kGyroPeriod = std::chrono::milliseconds(20);

}  // namespace

bool BaseFaults::inject(std::string_view kind, double value) {
  using F = BaseFaults;
  constexpr double kMany = 1e6;
  static constexpr FaultKind<F> kKinds[] = {
      {"silent", &F::silent},                  // takes and sends nothing
      {"deaf", &F::deaf},                      // takes nothing: what is sent to it is lost
      {"stuck", &F::stuck},                    // counts no further; what was turned meanwhile is never counted
      {"lifted", &F::lifted},                  // a wheel hangs in the air: the motors turn, the robot does not move
      {"bumped", &F::bumped},                  // a bumper is pressed
      {"lose", &F::lose, 0.0, kMany},          // bytes missing from the next frames, one from each
      {"insert", &F::insert, 0.0, kMany},      // foreign bytes in the next frames, one in each
      {"flip", &F::flip, 0.0, kMany},          // bytes damaged in the next frame
      {"checksum", &F::checksum, 0.0, kMany},  // frames whose last byte is wrong
      {"reset", &F::reset},                    // once: its power was away for a moment
      {"wrong", &F::factor, -1e3, 1e3},        // what the wheels turn is multiplied by it
  };
  return injectFault(kKinds, *this, kind, value);
}

void BaseFaults::damage(EmulatedBase::Bytes& frame) {
  const auto place = [&] { return static_cast<std::ptrdiff_t>(random_() % frame.size()); };
  if (checksum > 0) {
    --checksum;
    frame.back() ^= 1;
  }
  for (; flip > 0; --flip) frame[static_cast<std::size_t>(place())] ^= static_cast<std::uint8_t>(1 + random_() % 255);
  if (insert > 0) {
    --insert;
    frame.insert(frame.begin() + place(), static_cast<std::uint8_t>(random_()));
  }
  if (lose > 0) {
    --lose;
    frame.erase(frame.begin() + place());
  }
}

void CountingBase::renew(RobotModel& robot, Timestamp now) {
  const std::array<double, 2> angles = robot.wheelAngles();
  const double elapsed = now_ == Timestamp{} ? 0.0 : toSeconds(now - now_);  // [s]
  const SideSpeeds motors = sides();
  const std::array<double, 2> in_the_air = {motors.left * elapsed / geometry_.base.wheel_radius,
                                            motors.right * elapsed / geometry_.base.wheel_radius};
  for (std::size_t i = 0; known_ && !faults_.stuck && i < 2; ++i)
    turned_[i] += faults_.factor * (faults_.lifted ? in_the_air[i] : angles[i] - angles_[i]);
  angles_ = angles;
  known_ = true;
  now_ = now;
  if (now < next_gyro_) return;
  next_gyro_ = now + kGyroPeriod;
  turn_rate_ = robot.readImu().gyro[2];
}

void CountingBase::exchange(std::span<const std::uint8_t> in, Timestamp now, Bytes& out) {
  now_ = std::max(now_, now);
  if (std::exchange(faults_.reset, false)) {
    in_use_ = false;
    restart();
  }
  for (const std::uint8_t byte : in) {
    if (!faults_.silent && !faults_.deaf) take(byte, out);
  }
  send(out);
}

Twist2 CountingBase::drive() const {
  if (faults_.lifted) return {};
  const SideSpeeds motors = sides();
  return {.vx = 0.5 * (motors.left + motors.right),
          .omega = 0.5 * (motors.right - motors.left) / geometry_.base.half_track};
}

void CountingBase::deliver(const Outgoing& frame, Bytes& out) {
  if (faults_.silent) return;
  Bytes bytes(frame.bytes().begin(), frame.bytes().end());
  faults_.damage(bytes);
  out.insert(out.end(), bytes.begin(), bytes.end());
}

std::array<std::int64_t, 2> CountingBase::counts() const {
  const double per_radian = geometry_.counts_per_turn / (2.0 * std::numbers::pi);
  return {first_[0] + static_cast<std::int64_t>(std::floor(per_radian * turned_[0])),
          first_[1] + static_cast<std::int64_t>(std::floor(per_radian * turned_[1]))};
}

void CountingBase::setCountsBack() {
  first_ = {};
  turned_ = {};
}

}  // namespace slam::sim
