// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/board/board_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {

using robolink::Command;

namespace {

// The firmware's watchdog [OpenRE, 2_Package/robot_control/chassis.cpp].
constexpr double kCheckPeriod = 0.050;  // [s]
constexpr int kQualityOfACommand = 30, kQualityLost = 5, kWorst = 5, kBest = 100, kMotorsOff = 30, kMotorsOn = 70;

}  // namespace

BoardEmulator::BoardEmulator(const BaseKinematics& base, std::uint64_t seed) : base_(base), random_(seed) {}

robolink::MotorVector BoardEmulator::servos(const WheelVector& wheels) const {
  robolink::MotorVector motors{};
  for (std::size_t i = 0; i < motors.size(); ++i) motors[i] = static_cast<float>(wheels[i]);
  if (base_.type == BaseType::kDifferential) motors[0] = -motors[0];  // the left motor counts backwards
  return motors;
}

robolink::ChassisParameters BoardEmulator::chassis() const {
  using robolink::ChassisType;
  ChassisType type = ChassisType::kDifferential2;
  if (base_.type == BaseType::kOmni3) type = ChassisType::kOmni3;
  if (base_.type == BaseType::kMecanum4) type = ChassisType::kMecanum4;
  return {.type = type,
          .wheel_radius = static_cast<float>(base_.wheel_radius),
          .body_radius = static_cast<float>(base_.body_radius),
          .speed_low_filter = 0.5F,
          .imu_fusion = 0,
          .control_enable = 1,
          .max_speed = {1.2F, 1.2F, 4.0F},
          .max_acceleration = {1.0F, 1.0F, 4.0F}};
}

void BoardEmulator::renew(std::span<const double> angles, const robolink::Imu& imu, double uptime) {
  pass(uptime);
  if (faults_.stuck) return;
  wheels_.renew(angles, faults_.factor, uptime);
  imu_ = imu;
  imu_.online = faults_.imu_offline ? 0 : 1;
  imu_.gyro[2] += static_cast<float>(faults_.gyro_bias);
  info_ = {.system_time = static_cast<float>(uptime * 1e6),
           .cpu_temperature = 41.0F,
           .cpu_usage = 23.0F,
           .battery = 11.8F,
           .power_remain = 80.0F};
}

void BoardEmulator::Wheels::renew(std::span<const double> angles, double factor, double uptime) {
  const double elapsed = uptime - renewed_;  // [s]
  for (std::size_t i = 0; i < std::min(angles.size(), angles_.size()); ++i) {
    const double turned = factor * (angles[i] - angles_[i]);
    mileage_[i] += turned;
    speeds_[i] = elapsed > 0.0 ? turned / elapsed : 0.0;
    angles_[i] = angles[i];
  }
  renewed_ = uptime;
}

void BoardEmulator::pass(double uptime) {
  uptime_ = std::max(uptime_, uptime);
  watchdog_.pass(uptime_);
}

void BoardEmulator::Watchdog::command() { quality_ += kQualityOfACommand; }

void BoardEmulator::Watchdog::restart() {
  quality_ = kWorst;
  motors_on_ = false;
}

void BoardEmulator::Watchdog::pass(double uptime) {
  for (; next_check_ <= uptime; next_check_ += kCheckPeriod) {
    quality_ = std::clamp(quality_ - kQualityLost, kWorst, kBest);
    if (quality_ <= kMotorsOff) motors_on_ = false;
    if (quality_ >= kMotorsOn) motors_on_ = true;
  }
}

void BoardEmulator::restart() {
  decoder_.reset();
  wheels_.clear();
  greeted_ = false;
  watchdog_.restart();
  wanted_.setZero();
  late_.clear();
}

bool BoardEmulator::inject(std::string_view kind, double value) {
  // A cold start: it counts from 0.
  if (kind == "reset" && std::isfinite(value)) return restart(), true;
  return faults_.inject(kind, value);
}

bool BoardFaults::inject(std::string_view kind, double value) {
  using E = BoardFaults;
  constexpr double kAny = std::numeric_limits<double>::max();
  static constexpr FaultKind<E> kKinds[] = {
      {"silent", &E::silent},                       // answers nothing
      {"garbage", &E::garbage},                     // answers random bytes, as many as the answer has
      {"checksum", &E::wrong_checksums, 0.0, 1e6},  // so many answers have a wrong checksum
      {"stuck", &E::stuck},  // answers, but renews nothing; the wheels are counted on, and seen afterwards
      {"wrong", &E::factor, -kAny, kAny},          // what the wheels turn is multiplied by it
      {"gyro_wrong", &E::gyro_bias, -kAny, kAny},  // [rad/s] is added to the turn rate about z
      {"imu_offline", &E::imu_offline},            // reports that its IMU is offline
      {"slow", &E::delay, 0.0, 10000.0},           // [ms] that answers come later
  };
  return injectFault(kKinds, *this, kind, value);
}

void BoardEmulator::answer(Command command, std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& out) {
  if (faults_.silent) return;
  std::array<std::uint8_t, robolink::kMaxFrame> frame;
  const std::size_t size = robolink::encodeFrame(robolink::kSlave, robolink::kMaster, command, payload, frame);
  if (faults_.wrong_checksums > 0) {
    --faults_.wrong_checksums;
    ++frame[size - 1];
  }
  if (faults_.garbage) std::generate_n(frame.begin(), size, [this] { return static_cast<std::uint8_t>(random_()); });
  if (faults_.delay > Duration(0) || !late_.empty()) {  // never before one that is under way
    late_.push_back(
        {uptime_ + toSeconds(faults_.delay), {frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size)}});
  } else {
    out.insert(out.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

void BoardEmulator::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
  for (const std::uint8_t byte : bytes) {
    for (auto frame = decoder_.push(byte); frame; frame = decoder_.flush()) handle(*frame, out);
  }
  for (; !late_.empty() && late_.front().due <= uptime_; late_.pop_front()) {
    if (!faults_.silent) out.insert(out.end(), late_.front().bytes.begin(), late_.front().bytes.end());
  }
}

void BoardEmulator::handle(const robolink::Frame& frame, std::vector<std::uint8_t>& out) {
  const auto command = static_cast<Command>(frame.command);
  if (command == Command::kShakingHands) {  // stored, not acknowledged
    const auto pose = robolink::parseCoordinate(frame.payload);
    if (!pose) return;
    coordinate_ = pose;
    greeted_ = true;
    return;
  }
  if (!greeted_) return answer(Command::kShakingHands, {}, out);
  switch (command) {
    case Command::kGetMotorMileage:
      return answer(command, robolink::encodeMotorVector(servos(wheels_.mileage())), out);
    case Command::kGetMotorSpeed:
      return answer(command, robolink::encodeMotorVector(servos(wheels_.speeds())), out);
    case Command::kGetImu:
      return answer(command, robolink::encodeImu(imu_), out);
    case Command::kGetSystemInfo:
      return answer(command, robolink::encodeSystemInfo(info_), out);
    case Command::kReadChassisParameters:
      return answer(command, robolink::encodeChassis(chassis()), out);
    case Command::kSetRobotSpeed:  // what is set with a wrong size is ignored
      if (const auto speed = robolink::parseCoordinate(frame.payload)) {
        wanted_ = Eigen::Vector3f(speed->x, speed->y, speed->z).cast<double>();
        watchdog_.command();
        answer(command, {}, out);
      }
      return;
    case Command::kSetSystemInfo:
      if (const auto info = robolink::parseSystemInfo(frame.payload)) {
        told_ = info;
        answer(command, {}, out);
      }
      return;
    case Command::kClearCoordinateData:
      wheels_.clear();
      return answer(command, {}, out);
    default:
      return;
  }
}

}  // namespace slam::sim
