// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/can/can_emulator.hpp"

#include <algorithm>
#include <linux/can/error.h>
#include <numbers>
#include <utility>

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
namespace xsens = can::xsens;

constexpr Duration kEstimates = 10ms, kHeartbeat = 100ms, kImu = 10ms;
constexpr double kTurn = 2.0 * std::numbers::pi;   // [rad]
constexpr std::uint32_t kWatchdogExpired = 0x800;  // ODrive's AXIS_ERROR_WATCHDOG_TIMER_EXPIRED
constexpr std::array<int, 2> kNodes = {odrive::kLeftNode, odrive::kRightNode};

can::Frame errorFrame(std::uint32_t classes) { return {.id = classes, .size = 8, .error = true}; }

}  // namespace

void CanEmulator::step(Timestamp now, const CanReadings& readings, std::vector<can::Frame>& out) {
  if (!started_) started_ = next_estimates_ = next_heartbeat_ = next_imu_ = now;
  turn(now, readings);
  watch(now);
  const auto due = [now, slow = slow_](Timestamp& next, Duration period) {
    if (now < next) return false;
    period *= slow;
    next = std::max(next + period, now - period);  // after a long gap what was missed stays missed
    return true;
  };
  while (due(next_estimates_, kEstimates)) {
    for (std::size_t side = 0; side < 2; ++side) {
      const Drive& drive = drives_[side];
      send(now, odrive::encodeEncoderEstimates(
                    kNodes[side], {static_cast<float>(factor_ * drive.position), static_cast<float>(drive.velocity)}));
    }
  }
  while (due(next_heartbeat_, kHeartbeat)) {
    for (std::size_t side = 0; side < 2; ++side)
      send(now, odrive::encodeHeartbeat(kNodes[side], drives_[side].heartbeat));
  }
  while (due(next_imu_, kImu)) {
    if (!stuck_) imu_ = readings;
    send(now, xsens::encodeSampleTime(static_cast<std::uint32_t>((now - *started_) / 100us)));
    send(now, xsens::encodeQuaternion(imu_.attitude));
    send(now, xsens::encodeRateOfTurn(imu_.gyro));
    send(now, xsens::encodeAcceleration(imu_.accel));
  }
  for (; !line_.empty() && line_.front().due <= now; line_.pop_front()) out.push_back(line_.front().frame);
}

void CanEmulator::turn(Timestamp now, const CanReadings& readings) {
  const double dt = turned_ ? toSeconds(now - *turned_) : 0.0;
  if (turned_ && dt <= 0.0) return;
  for (std::size_t side = 0; side < 2 && !stuck_; ++side) {
    drives_[side].velocity = dt > 0.0 ? (readings.angles[side] - angles_[side]) / kTurn / dt : 0.0;
    drives_[side].position = readings.angles[side] / kTurn;
  }
  angles_ = readings.angles;
  turned_ = now;
}

void CanEmulator::watch(Timestamp now) {
  for (Drive& drive : drives_) {
    if (std::exchange(drive.fed, false)) drive.fed_at = now;
    if (watchdog_ == Duration(0) || now - drive.fed_at <= watchdog_) continue;
    drive.heartbeat.axis_error |= kWatchdogExpired;
    drive.heartbeat.state = static_cast<std::uint8_t>(odrive::AxisState::kIdle);
  }
}

std::array<float, 2> CanEmulator::drive() const {
  std::array<float, 2> speeds{};
  for (std::size_t side = 0; side < 2; ++side)
    if (drives_[side].armed()) speeds[side] = asked_[side];
  return speeds;
}

void CanEmulator::send(Timestamp now, can::Frame frame) {
  if (silent_ || bus_off_) return;
  if (garbage_) spoil(frame);
  line_.push_back({now + delay_, frame});
}

void CanEmulator::spoil(can::Frame& frame) {
  for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random_());
  if (random_() % 2 == 0) frame.size = static_cast<std::uint8_t>(random_() % 9);
}

void CanEmulator::receive(const can::Frame& frame) {
  for (std::size_t side = 0; side < 2; ++side) {
    if (static_cast<int>(frame.id >> 5) == kNodes[side]) drives_[side].fed = true;
    if (const auto velocity = odrive::parseInputVelocity(kNodes[side], frame)) {
      asked_[side] = velocity->velocity;
      ++commands_;
    }
    odrive::Heartbeat& heartbeat = drives_[side].heartbeat;
    const auto state = odrive::parseAxisState(kNodes[side], frame);
    const bool refused = state == std::uint32_t(odrive::AxisState::kClosedLoop) && heartbeat.axis_error != 0;
    if (state && !refused) heartbeat.state = static_cast<std::uint8_t>(*state);
    if (frame == odrive::encodeClearErrors(kNodes[side])) heartbeat.axis_error = 0;
  }
}

bool CanEmulator::inject(std::string_view kind, double value) {
  const bool on = value != 0.0;
  if (kind == "silent") {
    silent_ = on;
  } else if (kind == "garbage") {
    garbage_ = on;
  } else if (kind == "stuck") {
    stuck_ = on;
  } else if (kind == "wrong") {
    factor_ = value;
  } else if (kind == "slow") {
    if (value < 1.0) return false;
    slow_ = static_cast<int>(value);
  } else if (kind == "delay") {
    delay_ = fromSeconds(value * 1e-3);
  } else if (kind == "watchdog") {
    watchdog_ = fromSeconds(value);
  } else if (kind == "axis_error") {
    drives_[0].heartbeat.axis_error = static_cast<std::uint32_t>(value);
    drives_[0].heartbeat.state =
        static_cast<std::uint8_t>(on ? odrive::AxisState::kIdle : odrive::AxisState::kClosedLoop);
  } else if (kind == "bus_off") {
    if (on != bus_off_) line_.push_back({{}, errorFrame(on ? CAN_ERR_BUSOFF : CAN_ERR_RESTARTED)});
    bus_off_ = on;
  } else {
    return false;
  }
  return true;
}

}  // namespace slam::sim
