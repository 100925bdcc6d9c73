// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/can/can_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <linux/can/error.h>
#include <numbers>
#include <utility>

#include "tools/sim/faults/fault_values.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
namespace xsens = can::xsens;

constexpr Duration kHeartbeat = 100ms, kImu = 10ms;
constexpr double kTurn = 2.0 * std::numbers::pi;  // [rad]
// How a procedure of 0.6 ended.
constexpr std::uint8_t kSuccess = 0, kBusy = 1, kDisarmed = 3;
constexpr odrive::Version kVersion06{.hardware = {5, 2, 0}, .firmware = {0, 6, 9}};

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
  for (std::size_t side = 0; side < 2; ++side) {
    const bool asked = std::exchange(asked_version_[side], false);
    if (asked && dialect_ == odrive::Dialect::k06) send(now, odrive::encodeVersion(nodes_[side], kVersion06));
    const bool asked_watchdog = std::exchange(asked_watchdog_[side], false);
    if (asked_watchdog && dialect_ == odrive::Dialect::k06)
      send(now, odrive::encodeParameter(nodes_[side], {kWatchdogEndpoint, watchdog_ > Duration(0) ? 1U : 0U}));
  }
  while (due(next_estimates_, estimates_)) {
    for (std::size_t side = 0; side < 2; ++side) {
      const Drive& drive = drives_[side];
      send(now, odrive::encodeEncoderEstimates(
                    nodes_[side], {static_cast<float>(factor_ * drive.position), static_cast<float>(drive.velocity)}));
    }
  }
  while (due(next_heartbeat_, kHeartbeat)) {
    for (std::size_t side = 0; side < 2; ++side) {
      odrive::Heartbeat heartbeat = drives_[side].heartbeat;
      const bool busy = drives_[side].armed(), disarmed = heartbeat.axis_error != 0;
      heartbeat.trajectory_done = true;  // as long as no trajectory is asked for
      heartbeat.procedure_result = busy ? kBusy : disarmed ? kDisarmed : kSuccess;
      send(now, odrive::encodeHeartbeat(nodes_[side], heartbeat, dialect_));
    }
  }
  while (due(next_imu_, kImu)) {
    if (!stuck_) imu_ = readings;
    sendImu(now);
  }
  for (; !line_.empty() && line_.front().due <= now; line_.pop_front()) out.push_back(line_.front().frame);
}

void CanEmulator::sendImu(Timestamp now) {
  const auto isDue = [count = imu_samples_++](int every) { return every > 0 && count % every == 0; };
  if (isDue(time_every_)) send(now, xsens::encodeSampleTime(static_cast<std::uint32_t>((now - *started_) / 100us)));
  if (quaternion_) send(now, xsens::encodeQuaternion(imu_.attitude));
  send(now, xsens::encodeRateOfTurn(imu_.gyro));
  if (isDue(acceleration_every_)) send(now, xsens::encodeAcceleration(imu_.accel));
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
    drive.heartbeat.axis_error |=
        dialect_ == odrive::Dialect::k06 ? odrive::kWatchdogExpired06 : odrive::kWatchdogExpired05;
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
    if (static_cast<int>(frame.id >> 5) == nodes_[side]) drives_[side].fed = true;
    if (frame == odrive::requestVersion(nodes_[side])) asked_version_[side] = true;
    if (frame == odrive::requestParameter(nodes_[side], kWatchdogEndpoint)) asked_watchdog_[side] = true;
    if (const auto velocity = odrive::parseInputVelocity(nodes_[side], frame)) {
      asked_[side] = deaf_ && side == 0 ? 0.0F : velocity->velocity;
      ++commands_;
    }
    odrive::Heartbeat& heartbeat = drives_[side].heartbeat;
    const auto state = odrive::parseAxisState(nodes_[side], frame);
    const bool refused = state == std::uint32_t(odrive::AxisState::kClosedLoop) && heartbeat.axis_error != 0;
    if (state && !refused) heartbeat.state = static_cast<std::uint8_t>(*state);
    if (frame == odrive::encodeClearErrors(nodes_[side])) heartbeat.axis_error = 0;
  }
}

bool CanEmulator::inject(std::string_view kind, double value) {
  constexpr double kSeldom = 1000.0, kLongestDelay = 2000.0, kLongestWatch = 3600.0;  // [1, ms, s]
  bool on = false;
  const auto within = [value](double least, double most) { return value >= least && value <= most; };
  const auto disarm = [this](bool disarmed) {
    const auto state = disarmed ? odrive::AxisState::kIdle : odrive::AxisState::kClosedLoop;
    drives_[0].heartbeat.state = static_cast<std::uint8_t>(state);
  };
  if (kind == "silent") return setSwitch(silent_, value);
  if (kind == "garbage") return setSwitch(garbage_, value);
  if (kind == "stuck") return setSwitch(stuck_, value);
  if (kind == "deaf") return setSwitch(deaf_, value);
  if (kind == "quaternion") return setSwitch(quaternion_, value);
  if (kind == "imu_time") return setCount(time_every_, value, kSeldom);
  if (kind == "imu_acceleration") return setCount(acceleration_every_, value, kSeldom);
  if (kind == "wrong" && std::isfinite(value)) {
    factor_ = value;
  } else if (kind == "slow" && within(1.0, kSeldom)) {
    slow_ = static_cast<int>(value);
  } else if (kind == "delay" && within(0.0, kLongestDelay)) {
    delay_ = fromSeconds(value * 1e-3);
  } else if (kind == "watchdog" && within(0.0, kLongestWatch)) {
    watchdog_ = fromSeconds(value);
  } else if (kind == "axis_error" && within(0.0, std::numeric_limits<std::uint32_t>::max())) {
    drives_[0].heartbeat.axis_error = static_cast<std::uint32_t>(value);
    disarm(value != 0.0);
  } else if (kind == "idle" && setSwitch(on, value)) {
    disarm(on);
  } else if (kind == "firmware" && (value == 0.5 || value == 0.6)) {
    dialect_ = value == 0.5 ? odrive::Dialect::k05 : odrive::Dialect::k06;
  } else if (kind == "estimates" && within(1.0, 10e3)) {
    estimates_ = fromSeconds(1e-3 * value);
    next_estimates_ = {};
  } else if (kind == "bus_off" && setSwitch(on, value)) {
    if (on != bus_off_) line_.push_back({{}, errorFrame(on ? CAN_ERR_BUSOFF : CAN_ERR_RESTARTED)});
    bus_off_ = on;
  } else {
    return false;
  }
  return true;
}

}  // namespace slam::sim
