// SPDX-License-Identifier: BSD-3-Clause
// What the board's answers mean.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/board/handsfree_board.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using robolink::ChassisType;
using robolink::Command;

constexpr Duration kStanding = 120ms;        // the board renews its values every 20 to 50 ms
constexpr double kFastestWheel = 100.0;      // [rad/s] above what any of these motors can do
constexpr Duration kReadingJitter = 100ms;   // of the age of a reading
constexpr Duration kTimeStep = 180ms;        // between looks at the board's time, which it renews every 50 ms
constexpr int kStillLooks = 2;               // one may be a hiccup of the board
constexpr float kFinestStep = 1e5F;          // [us] of the board's time that can still tell whether it runs
constexpr double kGeometryTolerance = 0.05;  // [1] a calibration may differ from the model's figures by less

bool differential(ChassisType type) {
  return type == ChassisType::kDifferential2 || type == ChassisType::kDifferential4;
}

bool differs(double believed, float said) {
  return believed > 0.0 && std::abs(static_cast<double>(said) - believed) > kGeometryTolerance * believed;
}

}  // namespace

template <typename Value>
bool HandsfreeBoard::use(const std::optional<Value>& value, void (HandsfreeBoard::*handler)(const Value&)) {
  if (value) (this->*handler)(*value);
  return value.has_value();
}

bool HandsfreeBoard::handleAnswer(Command command, std::span<const std::uint8_t> payload) {
  switch (command) {
    case Command::kGetMotorMileage:
      return use(robolink::parseMotorVector(payload), &HandsfreeBoard::handleMileage);
    case Command::kGetImu:
      return use(robolink::parseImu(payload), &HandsfreeBoard::handleImu);
    case Command::kGetSystemInfo:
      return use(robolink::parseSystemInfo(payload), &HandsfreeBoard::handleInfo);
    case Command::kReadChassisParameters:
      return use(robolink::parseChassis(payload), &HandsfreeBoard::handleChassis);
    case Command::kGetMotorSpeed:
      return use(robolink::parseMotorVector(payload), &HandsfreeBoard::handleSpeeds);
    case Command::kClearCoordinateData:
      sendCoordinate();  // the board's own odometry went with the counters: give it back
      return true;
    default:
      return true;  // acknowledged
  }
}

std::array<double, 4> HandsfreeBoard::forward(const robolink::MotorVector& motors) const {
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(wheel_count_); ++i) {
    // The left motors of a differential base count negative when it drives forward.
    const bool left = differential(config_.chassis) && i % 2 == 0;
    values[i] = left ? -static_cast<double>(motors[i]) : static_cast<double>(motors[i]);
  }
  return values;
}

bool HandsfreeBoard::impossible(const robolink::MotorVector& mileage) const {
  if (!mileage_.values) return false;
  const Timestamp since = frozen_ ? mileage_.changed : mileage_.asked;
  const double limit = kFastestWheel * toSeconds(requested_ - since + kReadingJitter);  // [rad]
  for (std::size_t i = 0; i < static_cast<std::size_t>(wheel_count_); ++i) {
    if (std::abs(static_cast<double>(mileage[i]) - static_cast<double>((*mileage_.values)[i])) > limit) return true;
  }
  return false;
}

void HandsfreeBoard::handleMileage(const robolink::MotorVector& mileage) {
  const bool same = mileage_.values && mileage == *mileage_.values;
  restarted_ = restarted_ || impossible(mileage);
  auto stamp = std::optional(requested_ - fromSeconds(config_.sample_age));
  if (same) {
    mileage_.asked = requested_;
    // The same value again is stale while the wheels turn: leave it out, the next difference spans it.
    if (frozen_ || requested_ - mileage_.changed < kStanding) return;
  } else {
    stamp = mileage_.taken(requested_, answered_);
    mileage_.values = mileage;
    mileage_.asked = mileage_.changed = requested_;
    if (!stamp) return;  // a speed from it would be wrong: the next difference spans it
  }
  mileage_.used = requested_;
  sinks_.wheels({*stamp, forward(mileage), wheel_count_, restarted_});
  restarted_ = false;
  wheels_.countSample(requested_);
  if (!frozen_) wheels_.set(DeviceState::kStreaming);
}

void HandsfreeBoard::handleImu(const robolink::Imu& imu) {
  if ((imu.online & 1) == 0) {
    imu_.set(DeviceState::kFault, problem::kBoardImuOffline);
    return;
  }
  if (last_imu_.values && last_imu_.values->gyro == imu.gyro && last_imu_.values->accel == imu.accel) {
    last_imu_.asked = requested_;  // not renewed yet
    return;
  }
  ImuSample sample;
  sample.stamp = last_imu_.taken(requested_, answered_).value_or(requested_ - fromSeconds(config_.sample_age));
  last_imu_.values = imu;
  last_imu_.asked = last_imu_.used = requested_;
  for (int i = 0; i < 3; ++i) {
    sample.gyro[i] = static_cast<double>(imu.gyro[static_cast<std::size_t>(i)]);
    sample.accel[i] = static_cast<double>(imu.accel[static_cast<std::size_t>(i)]);
  }
  sinks_.imu(sample);
  imu_.countSample(requested_);
  imu_.set(DeviceState::kStreaming);
}

void HandsfreeBoard::handleInfo(const robolink::SystemInfo& info) {
  battery_ = info.battery;
  board_time_ = info.system_time * 1e-6F;
  if (requested_ - time_asked_ < kTimeStep) return;
  time_asked_ = requested_;
  const bool runs = info.system_time != last_system_time_;
  last_system_time_ = info.system_time;
  // A board whose time stands still, but did not always, takes no more readings: wheels that stand are then no news.
  // The board's time is a float: after some weeks its steps are longer than the interval between two looks.
  const bool fine =
      std::nextafter(info.system_time, std::numeric_limits<float>::infinity()) - info.system_time < kFinestStep;
  still_looks_ = runs ? 0 : still_looks_ + 1;
  frozen_ = fine && time_ran_ && still_looks_ >= kStillLooks;
  time_ran_ = time_ran_ || runs;
  if (frozen_) setBoth(DeviceState::kStale, problem::kBoardFrozen);
}

void HandsfreeBoard::handleChassis(const robolink::ChassisParameters& chassis) {
  chassis_tries_left_ = 0;
  wheel_radius_ = chassis.wheel_radius;
  body_radius_ = chassis.body_radius;
  Problem finding;
  // The first axle of four driven wheels does for a base that is configured as two-wheeled.
  const bool suits = chassis.type == config_.chassis ||
                     (config_.chassis == ChassisType::kDifferential2 && chassis.type == ChassisType::kDifferential4);
  if (differs(config_.body_radius, chassis.body_radius)) finding = problem::kBoardBodyRadius;
  if (differs(config_.wheel_radius, chassis.wheel_radius)) finding = problem::kBoardWheelRadius;
  if (!suits) finding = problem::kBoardOtherBase;
  finding_.store(finding);
}

void HandsfreeBoard::handleSpeeds(const robolink::MotorVector& speeds) {
  if (sinks_.speeds) sinks_.speeds({requested_, forward(speeds), wheel_count_});
}

}  // namespace slam
