// SPDX-License-Identifier: BSD-3-Clause
// What the board's answers mean.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/board/handsfree_board.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using robolink::ChassisType;
using robolink::Command;

constexpr Duration kStanding = 120ms;       // the board renews its values every 20 to 50 ms
constexpr float kLongRun = 2048.0F;         // [rad] above, single precision begins to cost: 0.04 % of the way
constexpr Duration kStandingForClear = 1s;  // before the counters are set back
constexpr std::int64_t kNanoseconds = 1'000'000'000;
constexpr double kFastestBoardWheel = 100.0;  // [rad/s] above what any of these motors can do
constexpr Duration kReadingJitter = 100ms;    // of the age of a reading
constexpr Duration kTimeStep = 180ms;         // between looks at the board's time, which it renews every 50 ms
constexpr int kStillLooks = 2;                // one may be a hiccup of the board
constexpr float kFinestStep = 1e5F;           // [us] of the board's time that can still tell whether it runs
constexpr double kModelTolerance = 0.05;      // [1] a calibration may differ from the model's figures by less

int wheelsOf(ChassisType type) {
  switch (type) {
    case ChassisType::kDifferential2:
      return 2;
    case ChassisType::kOmni3:
      return 3;
    default:
      return 4;
  }
}

bool differential(ChassisType type) {
  return type == ChassisType::kDifferential2 || type == ChassisType::kDifferential4;
}

bool differs(double configured, float reported) {
  return configured > 0.0 && std::abs(static_cast<double>(reported) - configured) > kModelTolerance * configured;
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

HandsfreeBoard::Mileage::Mileage(ChassisType chassis) : chassis_(chassis), count_(wheelsOf(chassis)) {}

std::array<double, 4> HandsfreeBoard::Mileage::forward(const robolink::MotorVector& motors) const {
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    // The left motors of a differential base count negative when it drives forward.
    const bool left = differential(chassis_) && i % 2 == 0;
    values[i] = left ? -static_cast<double>(motors[i]) : static_cast<double>(motors[i]);
  }
  return values;
}

bool HandsfreeBoard::Mileage::impossible(const robolink::MotorVector& mileage, Timestamp requested, bool frozen) const {
  if (!last_.values) return false;
  const Timestamp since = frozen ? last_.changed : last_.asked;
  const double limit = kFastestBoardWheel * toSeconds(requested - since + kReadingJitter);  // [rad]
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    if (std::abs(static_cast<double>(mileage[i]) - static_cast<double>((*last_.values)[i])) > limit) return true;
  }
  return false;
}

std::optional<WheelAngles> HandsfreeBoard::Mileage::take(const robolink::MotorVector& mileage, const Request& request,
                                                         bool frozen, double age) {
  const Timestamp requested = request.requested();
  const bool same = last_.values && mileage == *last_.values;
  restarted_ = restarted_ || impossible(mileage, requested, frozen);
  auto stamp = std::optional(requested - fromSeconds(age));
  if (same) {
    last_.asked = requested;
    // The same value again is stale while the wheels turn.
    if (frozen || requested - last_.changed < kStanding) return std::nullopt;
  } else {
    stamp = last_.taken(requested, request.answered());
    last_.values = mileage;
    last_.asked = last_.changed = requested;
    if (!stamp) return std::nullopt;
  }
  last_.used = requested;
  return WheelAngles{*stamp, forward(mileage), count_, std::exchange(restarted_, false)};
}

bool HandsfreeBoard::Mileage::isCoarse(Timestamp now) const {
  const auto coarse = [](float angle) { return std::abs(angle) > kLongRun; };
  return last_.values && now - last_.changed >= kStandingForClear &&
         std::any_of(last_.values->begin(), last_.values->end(), coarse);
}

void HandsfreeBoard::handleMileage(const robolink::MotorVector& mileage) {
  const auto angles = mileage_.take(mileage, request_, time_.isFrozen(), config_.sample_age);
  if (!angles) return;
  sinks_.wheels(*angles);
  wheels_.countSample(request_.requested());
  if (!time_.isFrozen()) wheels_.set(DeviceState::kStreaming);
}

void HandsfreeBoard::handleImu(const robolink::Imu& imu) {
  if ((imu.online & 1) == 0) {
    imu_.set(DeviceState::kFault, problem::kBoardImuOffline);
    return;
  }
  const Timestamp requested = request_.requested();
  if (last_imu_.values && last_imu_.values->gyro == imu.gyro && last_imu_.values->accel == imu.accel) {
    last_imu_.asked = requested;  // not renewed yet
    return;
  }
  ImuSample sample;
  sample.stamp = last_imu_.taken(requested, request_.answered()).value_or(requested - fromSeconds(config_.sample_age));
  last_imu_.values = imu;
  last_imu_.asked = last_imu_.used = requested;
  for (int i = 0; i < 3; ++i) {
    sample.gyro[i] = static_cast<double>(imu.gyro[static_cast<std::size_t>(i)]);
    sample.accel[i] = static_cast<double>(imu.accel[static_cast<std::size_t>(i)]);
  }
  sinks_.imu(sample);
  imu_.countSample(requested);
  imu_.set(DeviceState::kStreaming);
}

void HandsfreeBoard::handleInfo(const robolink::SystemInfo& info) {
  report_.take(info);
  if (time_.look(info.system_time, request_.requested())) port_.report(DeviceState::kStale, problem::kBoardFrozen);
}

void HandsfreeBoard::Report::take(const robolink::SystemInfo& info) { battery_ = info.battery; }

robolink::SystemInfo HandsfreeBoard::Host::infoAt(Timestamp now) const {
  robolink::SystemInfo info;
  if (const std::int64_t offset = local_time_offset_; offset != 0)
    info.local_time = robolink::localTimeAt((now.time_since_epoch().count() + offset) / kNanoseconds);
  return info;
}

void HandsfreeBoard::BoardTime::restart() {
  ran_ = frozen_ = false;
  still_looks_ = 0;
}

bool HandsfreeBoard::BoardTime::look(float time, Timestamp asked) {
  if (asked - asked_ < kTimeStep) return false;
  asked_ = asked;
  const bool runs = time != last_;
  last_ = time;
  // A board whose time stands still, but did not always, takes no more readings: wheels that stand are then no news.
  // The board's time is a float: after some weeks its steps are longer than the interval between two looks.
  const bool fine = std::nextafter(time, std::numeric_limits<float>::infinity()) - time < kFinestStep;
  still_looks_ = runs ? 0 : still_looks_ + 1;
  frozen_ = fine && ran_ && still_looks_ >= kStillLooks;
  ran_ = ran_ || runs;
  return frozen_;
}

void HandsfreeBoard::handleChassis(const robolink::ChassisParameters& chassis) {
  schedule_.noteChassis();
  report_.take(chassis, config_);
}

void HandsfreeBoard::Report::take(const robolink::ChassisParameters& chassis, const HandsfreeConfig& config) {
  wheel_radius_ = chassis.wheel_radius;
  body_radius_ = chassis.body_radius;
  Problem finding;
  // The first axle of four driven wheels does for a base that is configured as two-wheeled.
  const bool suits = chassis.type == config.chassis ||
                     (config.chassis == ChassisType::kDifferential2 && chassis.type == ChassisType::kDifferential4);
  if (differs(config.body_radius, chassis.body_radius)) finding = problem::kBoardBodyRadius;
  if (differs(config.wheel_radius, chassis.wheel_radius)) finding = problem::kBoardWheelRadius;
  if (!suits) finding = problem::kBoardOtherBase;
  finding_.store(finding);
}

void HandsfreeBoard::handleSpeeds(const robolink::MotorVector& speeds) {
  if (sinks_.speeds) sinks_.speeds(mileage_.speeds(speeds, request_.requested()));
}

}  // namespace slam
