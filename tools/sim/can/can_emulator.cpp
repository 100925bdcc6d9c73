// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/can/can_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <linux/can/error.h>
#include <numbers>
#include <utility>

#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
namespace vesc = can::vesc;
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
  const auto due = [now, slow = faults_.slow](Timestamp& next, Duration period) {
    if (now < next) return false;
    period *= slow;
    next = std::max(next + period, now - period);  // after a long gap what was missed stays missed
    return true;
  };
  const bool is_vesc = protocol_ == can::Protocol::kVesc;
  if (!is_vesc) sendAnswers(now);
  while (due(next_estimates_, is_vesc ? 2 * estimates_ : estimates_)) is_vesc ? sendStatus(now) : sendEstimates(now);
  while (!is_vesc && due(next_heartbeat_, kHeartbeat)) {
    for (std::size_t side = 0; side < 2; ++side) {
      odrive::Heartbeat heartbeat = drives_[side].heartbeat;
      const bool busy = drives_[side].armed(), disarmed = heartbeat.axis_error != 0;
      heartbeat.trajectory_done = true;  // as long as no trajectory is asked for
      heartbeat.procedure_result = busy ? kBusy : disarmed ? kDisarmed : kSuccess;
      send(now, odrive::encodeHeartbeat(drives_[side].node, heartbeat, faults_.dialect));
    }
  }
  while (due(next_imu_, kImu)) {
    if (!faults_.stuck) imu_ = readings;
    sendImu(now);
  }
  for (; !line_.empty() && line_.front().due <= now; line_.pop_front()) out.push_back(line_.front().frame);
}

void CanEmulator::sendAnswers(Timestamp now) {
  for (std::size_t side = 0; side < 2; ++side) {
    const bool asked = std::exchange(drives_[side].asked_version, false);
    if (asked && faults_.dialect == odrive::Dialect::k06)
      send(now, odrive::encodeVersion(drives_[side].node, kVersion06));
    const bool asked_watchdog = std::exchange(drives_[side].asked_watchdog, false);
    if (asked_watchdog && faults_.dialect == odrive::Dialect::k06)
      send(now, odrive::encodeParameter(drives_[side].node, {kWatchdogEndpoint, faults_.watchdog > 0.0 ? 1U : 0U}));
  }
}

void CanEmulator::sendEstimates(Timestamp now) {
  for (std::size_t side = 0; side < 2; ++side) {
    const Drive& drive = drives_[side];
    send(now, odrive::encodeEncoderEstimates(drives_[side].node, {static_cast<float>(faults_.factor * drive.position),
                                                                  static_cast<float>(drive.velocity)}));
  }
}

void CanEmulator::sendStatus(Timestamp now) {
  constexpr double kSeconds = 60.0;  // in a minute
  constexpr double kSteps = vesc::kStepsPerElectricTurn * kPolePairs;
  constexpr vesc::Status4 kTemperatures{.transistors = 312, .motor = 350};
  for (std::size_t side = 0; side < 2; ++side) {
    const Drive& drive = drives_[side];
    const double erpm = kSeconds * kPolePairs * drive.velocity,
                 steps = std::floor(kSteps * faults_.factor * drive.position);
    send(now, vesc::encode(drives_[side].node, vesc::Status{.erpm = static_cast<std::int32_t>(std::lround(erpm))}));
    send(now, vesc::encode(drives_[side].node, kTemperatures));
    send(now, vesc::encode(drives_[side].node,
                           vesc::Status5{.tachometer = static_cast<std::int32_t>(steps), .voltage = 240}));
  }
}

void CanEmulator::sendImu(Timestamp now) {
  const auto isDue = [count = imu_samples_++](int every) { return every > 0 && count % every == 0; };
  if (isDue(faults_.time_every))
    send(now, xsens::encodeSampleTime(static_cast<std::uint32_t>((now - *started_) / 100us)));
  if (faults_.quaternion) send(now, xsens::encodeQuaternion(imu_.attitude));
  send(now, xsens::encodeRateOfTurn(imu_.gyro));
  if (isDue(faults_.acceleration_every)) send(now, xsens::encodeAcceleration(imu_.accel));
}

void CanEmulator::turn(Timestamp now, const CanReadings& readings) {
  const double dt = turned_ ? toSeconds(now - *turned_) : 0.0;
  if (turned_ && dt <= 0.0) return;
  for (std::size_t side = 0; side < 2 && !faults_.stuck; ++side) {
    drives_[side].velocity = dt > 0.0 ? (readings.angles[side] - drives_[side].angle) / kTurn / dt : 0.0;
    drives_[side].position = readings.angles[side] / kTurn;
  }
  for (std::size_t side = 0; side < 2; ++side) drives_[side].angle = readings.angles[side];
  turned_ = now;
}

void CanEmulator::watch(Timestamp now) {
  for (Drive& drive : drives_) {
    if (std::exchange(drive.fed, false)) drive.fed_at = now;
    if (protocol_ == can::Protocol::kVesc) {
      if (toSeconds(now - drive.fed_at) > vesc::kTimeout) drive.asked = 0.0F;
      continue;
    }
    if (faults_.watchdog == 0.0 || toSeconds(now - drive.fed_at) <= faults_.watchdog) continue;
    drive.heartbeat.axis_error |=
        faults_.dialect == odrive::Dialect::k06 ? odrive::kWatchdogExpired06 : odrive::kWatchdogExpired05;
    drive.heartbeat.state = static_cast<std::uint8_t>(odrive::AxisState::kIdle);
  }
}

std::array<float, 2> CanEmulator::drive() const {
  std::array<float, 2> speeds{};
  for (std::size_t side = 0; side < 2; ++side)
    if (drives_[side].armed()) speeds[side] = drives_[side].asked;
  return speeds;
}

void CanEmulator::send(Timestamp now, can::Frame frame) {
  if (faults_.silent || bus_off_) return;
  if (faults_.garbage) spoil(frame);
  line_.push_back({now + faults_.delay, frame});
}

void CanEmulator::spoil(can::Frame& frame) {
  for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random_());
  if (random_() % 2 == 0) frame.size = static_cast<std::uint8_t>(random_() % 9);
}

void CanEmulator::receive(const can::Frame& frame) {
  for (std::size_t side = 0; side < 2; ++side) {
    const auto erpm = protocol_ == can::Protocol::kVesc ? vesc::parseSetRpm(drives_[side].node, frame) : std::nullopt;
    if (erpm) {
      constexpr float kErpm = 60.0F * kPolePairs;  // [1/min] of one turn in a second
      drives_[side].asked = faults_.deaf && side == 0 ? 0.0F : static_cast<float>(*erpm) / kErpm;
      drives_[side].fed = true;
      ++commands_;
    }
    if (protocol_ == can::Protocol::kVesc) continue;
    if (static_cast<int>(frame.id >> 5) == drives_[side].node) drives_[side].fed = true;
    if (frame == odrive::requestVersion(drives_[side].node)) drives_[side].asked_version = true;
    if (frame == odrive::requestParameter(drives_[side].node, kWatchdogEndpoint)) drives_[side].asked_watchdog = true;
    if (const auto velocity = odrive::parseInputVelocity(drives_[side].node, frame)) {
      drives_[side].asked = faults_.deaf && side == 0 ? 0.0F : velocity->velocity;
      ++commands_;
    }
    odrive::Heartbeat& heartbeat = drives_[side].heartbeat;
    const auto state = odrive::parseAxisState(drives_[side].node, frame);
    const bool refused = state == std::uint32_t(odrive::AxisState::kClosedLoop) && heartbeat.axis_error != 0;
    if (state && !refused) heartbeat.state = static_cast<std::uint8_t>(*state);
    if (frame == odrive::encodeClearErrors(drives_[side].node)) heartbeat.axis_error = 0;
  }
}

bool CanEmulator::inject(std::string_view kind, double value) {
  using E = CanEmulator;
  static constexpr auto idle = [](E& can, double to) {
    can.drives_[0].heartbeat.state =
        static_cast<std::uint8_t>(to != 0.0 ? odrive::AxisState::kIdle : odrive::AxisState::kClosedLoop);
    return true;
  };
  static constexpr FaultKind<E> kKinds[] = {
      // The error word of the left drive, which disarms it; 0 takes it back.
      {"axis_error",
       [](E& can, double to) {
         can.drives_[0].heartbeat.axis_error = static_cast<std::uint32_t>(to);
         return idle(can, to);
       },
       0.0, 0xFFFFFFFF},
      {"idle", idle},  // takes the left drive out of closed loop without an error; 0 arms it
      {"estimates",    // [ms] their period, 10 as delivered
       [](E& can, double to) {
         can.estimates_ = fromSeconds(1e-3 * to);
         can.next_estimates_ = {};
         return true;
       },
       1.0, 10e3},
      {"bus_off",  // 0: of a controller that was restarted
       [](E& can, double to) {
         const bool on = to != 0.0;
         if (on != can.bus_off_) can.line_.push_back({{}, errorFrame(on ? CAN_ERR_BUSOFF : CAN_ERR_RESTARTED)});
         can.bus_off_ = on;
         return true;
       }},
  };
  return faults_.inject(kind, value) || injectFault(kKinds, *this, kind, value);
}

bool CanFaults::inject(std::string_view kind, double value) {
  using E = CanFaults;
  constexpr double kSeldom = 1000.0, kLongestDelay = 2000.0, kLongestWatch = 3600.0;  // [1, ms, s]
  constexpr double kAny = std::numeric_limits<double>::max();
  static constexpr FaultKind<E> kKinds[] = {
      {"silent", &E::silent},                    // sends nothing
      {"garbage", &E::garbage},                  // frames of random bytes
      {"stuck", &E::stuck},                      // the same values again and again
      {"wrong", &E::factor, -kAny, kAny},        // factor of the positions
      {"slow", &E::slow, 1.0, kSeldom},          // factor of the periods
      {"delay", &E::delay, 0.0, kLongestDelay},  // [ms]
      {"watchdog", &E::watchdog, 0.0,
       kLongestWatch},     // [s] without a frame from the host, then an error; 0: off, as delivered
      {"deaf", &E::deaf},  // the left drive leaves speeds out
      {"firmware",         // of both drives, 0.5 or 0.6
       [](E& faults, double to) {
         if (to != 0.5 && to != 0.6) return false;
         faults.dialect = to == 0.5 ? odrive::Dialect::k05 : odrive::Dialect::k06;
         return true;
       }},
      {"imu_time", &E::time_every, 0.0, kSeldom},                  // sent with every so many'th turn rate, 0 never
      {"imu_acceleration", &E::acceleration_every, 0.0, kSeldom},  // the same
      {"quaternion", &E::quaternion},                              // it is sent
  };
  return injectFault(kKinds, *this, kind, value);
}

}  // namespace slam::sim
