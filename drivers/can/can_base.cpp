// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_base.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <thread>

#include "drivers/can/can_socket.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
namespace vesc = can::vesc;
namespace xsens = can::xsens;

constexpr Duration kSilent = 500ms;        // estimates come every 10 ms
constexpr Duration kHeartbeatSilent = 1s;  // heartbeats every 100 ms
constexpr Duration kCommandPeriod = 20ms;  // 50 Hz
constexpr Duration kLetGo = 2s;            // without a command, until a wheel that did not follow is tried again
constexpr Duration kReopen = 50ms;         // between attempts, where wheels may turn until the interface is there again
constexpr int kStopTries = 100;            // at the end, a millisecond apart
constexpr Duration kSlowEstimates = 95ms;  // from here on the pose between them suffers
constexpr double kHot = 85.0;     // [deg C] of transistors: from here on a VESC as delivered limits its current
constexpr int kMostFrames = 200;  // a tick: ten times what the bus carries in that time

constexpr std::array<const char*, 2> kSides = {"left", "right"};

bool isVesc(const CanBaseConfig& config) { return config.protocol == can::Protocol::kVesc; }

std::vector<std::uint32_t> idsOf(const CanBaseConfig& config) {
  std::vector<std::uint32_t> ids;
  for (const int node : config.nodes) {
    if (!config.wheels) break;
    if (isVesc(config)) {
      for (const auto packet : {vesc::Packet::kStatus, vesc::Packet::kStatus4, vesc::Packet::kStatus5})
        ids.push_back(vesc::idOf(node, packet) | CanPort::kExtended);
      continue;
    }
    ids.push_back(odrive::idOf(node, odrive::Command::kHeartbeat));
    ids.push_back(odrive::idOf(node, odrive::Command::kEncoderEstimates));
    if (config.commands) ids.push_back(odrive::idOf(node, odrive::Command::kVersion));
  }
  if (config.imu) ids.insert(ids.end(), {xsens::kSampleTime, xsens::kRateOfTurn, xsens::kAcceleration});
  return ids;
}

Problem problemOf(CanLinkState state, const std::string& interface) {
  const auto of = [&](const ProblemKind& kind) { return Problem(kind, {}, {interface}); };
  switch (state) {
    case CanLinkState::kGone:
      return of(problem::kCanGone);
    case CanLinkState::kUnsupported:
      return of(problem::kCanUnsupported);
    case CanLinkState::kRefused:
      return of(problem::kCanRefused);
    case CanLinkState::kDown:
      return of(problem::kCanDown);
    case CanLinkState::kBusOff:
      return of(problem::kCanBusOff);
    case CanLinkState::kErrorPassive:
      return of(problem::kCanPassive);
    case CanLinkState::kUp:
      break;
  }
  return {};
}

/// What an ODrive's problem is with a VESC, whose settings are others.
const ProblemKind& vescKind(const ProblemKind& kind) {
  if (std::strcmp(kind.id, problem::kNoEstimates.id) == 0) return problem::kVescNoEstimates;
  if (std::strcmp(kind.id, problem::kNotFollowing.id) == 0) return problem::kVescNotFollowing;
  return kind;
}

}  // namespace

CanBase::CanBase(const CanBaseConfig& config, Clock now, Sinks sinks)
    : CanBase(config, now, std::move(sinks), makeSocketCanPort(now)) {}

CanBase::CanBase(const CanBaseConfig& config, Clock now, Sinks sinks, std::unique_ptr<CanPort> port)
    : config_(config),
      now_(now),
      sinks_(std::move(sinks)),
      link_(std::move(port), config.interface, idsOf(config), config.commands ? kReopen : Duration(1s)),
      vescs_{VescDrive(config.nodes[0], config.pole_pairs), VescDrive(config.nodes[1], config.pole_pairs)},
      wheels_(config.wheel),
      imu_(config.R_base_imu),
      command_(config.limits) {
  config_.commands = config.commands && config.wheels;
  for (std::size_t side = 0; side < 2 && isVesc(config); ++side) axes_[side].setStep(vescs_[side].step());
  if (!config_.wheels) wheel_status_.set(DeviceState::kAbsent, problem::kNotWanted);
  if (!config_.imu) imu_.status().set(DeviceState::kAbsent, problem::kNotWanted);
}

void CanBase::tick() {
  const Timestamp now = now_();
  takeCommand(now);
  link_.tick(now);
  StampedCanFrame received;
  for (int i = 0; i < kMostFrames && link_.receive(received); ++i) handle(received);
  silence_.look(link_.usable(), now);
  if (config_.commands) watchObedience(now);
  if (config_.wheels) watchWheels(now);
  if (config_.imu) watchImu(now);
  sendCommand(now);
  askVersions(now);
}

void CanBase::handle(const StampedCanFrame& received) {
  if (!config_.wheels) return handleImu(received);
  if (received.frame.extended) return handleVesc(received);
  if (isVesc(config_)) return handleImu(received);
  for (std::size_t side = 0; side < 2; ++side) {
    const auto is = [&](odrive::Command command) {
      return received.frame.id == odrive::idOf(config_.nodes[side], command);
    };
    if (is(odrive::Command::kEncoderEstimates)) return handleEstimates(side, received);
    if (is(odrive::Command::kHeartbeat)) return handleHeartbeat(side, received);
    if (!is(odrive::Command::kVersion)) continue;
    if (const auto version = odrive::parseVersion(config_.nodes[side], received.frame))
      axes_[side].addVersion(*version);
    return;
  }
  if (config_.imu) handleImu(received);
}

void CanBase::handleHeartbeat(std::size_t side, const StampedCanFrame& received) {
  CanAxis& axis = axes_[side];
  if (received.frame.id == xsens::kQuaternion && axis.sharesHeartbeat(received.stamp)) return;
  if (!axis.addHeartbeat(received.stamp, config_.nodes[side], received.frame)) wheels_.reject();
}

void CanBase::handleEstimates(std::size_t side, const StampedCanFrame& received) {
  const auto estimates = odrive::parseEncoderEstimates(config_.nodes[side], received.frame);
  if (estimates) return addEstimates(side, received.stamp, *estimates);
  wheels_.reject();
  axes_[side].addBadEstimates(received.stamp);
  storeRejects();
}

/// A VESC tells on CAN neither its state nor its faults: as long as it sends it is taken for one that obeys, and a
/// wheel that does not is seen by how it turns.
void CanBase::handleVesc(const StampedCanFrame& received) {
  bool known = false;
  for (std::size_t side = 0; side < 2; ++side) {
    const VescDrive::News news = vescs_[side].take(received.stamp, received.frame);
    known = known || news.is_status;
    if (news.is_status)
      axes_[side].addHeartbeat(received.stamp, {.state = static_cast<std::uint8_t>(odrive::AxisState::kClosedLoop)});
    if (news.estimates) addEstimates(side, received.stamp, *news.estimates);
  }
  if (known) return;
  wheels_.reject();
  storeRejects();
}

void CanBase::addEstimates(std::size_t side, Timestamp stamp, const odrive::EncoderEstimates& estimates) {
  axes_[side].addEstimates(stamp, estimates);
  const auto pair = wheels_.add(side, stamp, estimates);
  const bool invalid = axes_[0].positionInvalid() || axes_[1].positionInvalid();
  if (pair && !invalid) emit(*pair);
  if (pair && invalid && pair->restarted) wheels_.beginAnew();
  storeRejects();
}

void CanBase::emit(const CanWheels::Pair& pair) {
  last_pair_ = now_();
  sinks_.wheels({pair.stamp, {pair.angles[0], pair.angles[1]}, 2, pair.restarted});
  wheel_status_.countSample(pair.stamp);
}

void CanBase::handleImu(const StampedCanFrame& received) {
  if (const auto sample = imu_.add(received, now_())) sinks_.imu(*sample);
}

bool CanBase::watchLink(DeviceStatus& status) {
  if (link_.usable()) return false;
  const bool fault = link_.state() == CanLinkState::kBusOff;
  status.set(fault ? DeviceState::kFault : DeviceState::kAbsent, problemOf(link_.state(), config_.interface));
  return true;
}

Duration CanBase::patience(std::size_t side) const { return patienceFor(wheels_.period(side), kSilent); }

void CanBase::watchWheels(Timestamp now) {
  if (watchLink(wheel_status_)) return;
  const auto stale = [&](const Problem& why) { setStale(wheel_status_, why); };
  std::array<bool, 2> silent{}, dead{};
  for (std::size_t side = 0; side < 2; ++side) {
    silent[side] = silence_.since(axes_[side].estimates(), now, patience(side));
    dead[side] = silent[side] && silence_.since(axes_[side].heartbeat(), now, kSilent);
  }
  if (dead[0] && dead[1])
    return stale({problem::kNoWheels, {static_cast<double>(config_.nodes[0]), static_cast<double>(config_.nodes[1])}});
  if (link_.isBlocked()) return wheel_status_.set(DeviceState::kFault, {problem::kCanBlocked, {}, {config_.interface}});
  for (std::size_t side = 0; side < 2; ++side) {
    if (dead[side]) return stale(ofWheel(config_.commands ? problem::kNoFramesStops : problem::kNoFrames, side));
    if (!silent[side]) continue;
    const bool bad = axes_[side].hasBadEstimates(now, patience(side));
    return stale(ofWheel(bad ? problem::kBadEstimates : problem::kNoEstimates, side));
  }
  for (std::size_t side = 0; side < 2; ++side) {
    if (axes_[side].faulty()) return wheel_status_.set(DeviceState::kFault, axisError(side));
    if (const Problem hindered = config_.commands ? hindrance(side) : Problem())
      return wheel_status_.set(DeviceState::kFault, hindered);
    if (axes_[side].frozen()) return wheel_status_.set(DeviceState::kFault, ofWheel(problem::kWheelFrozen, side));
  }
  const auto senseless = [&] {
    for (std::size_t side = 0; side < 2; ++side) {
      if (wheels_.period(side) > kSilent)  // too seldom for one to be judged by the one before
        return wheel_status_.set(DeviceState::kStale, slowEstimates(side));
    }
    stale(problem::kWheelsSenseless);
  };
  const Duration patient = std::max(patience(0), patience(1));
  if (!silence_.isFresh(last_pair_)) {
    if (!silence_.since({}, now, patient))
      return wheel_status_.set(DeviceState::kOpening, {problem::kWaitsForFrames, {}, {"the wheels'"}});
    return senseless();
  }
  if (silence_.since(last_pair_, now, patient)) return senseless();
  wheel_status_.set(DeviceState::kStreaming, warning(now));
}

Problem CanBase::warning(Timestamp now) const {
  Problem slow, other;
  for (std::size_t side = 0; side < 2; ++side) {
    if (wheels_.period(side) >= kSlowEstimates) slow = slowEstimates(side);
    if (vescs_[side].transistors() >= kHot) other = ofWheel(problem::kVescHot, side);
    if (axes_[side].isShared()) {
      other = ofWheel(problem::kSharedId, side);
    } else if (silence_.since(axes_[side].heartbeat(), now, kHeartbeatSilent)) {
      other = noHeartbeat(side);
    } else if (axes_[side].lastHeartbeat() && !axes_[side].inClosedLoop()) {
      other = notArmed(side);
    }
  }
  return slow ? slow : other;
}

void CanBase::setStale(DeviceStatus& status, const Problem& why) const {
  const bool passive = link_.state() == CanLinkState::kErrorPassive;
  status.set(DeviceState::kStale, passive ? problemOf(link_.state(), config_.interface) : why);
}

Problem CanBase::ofWheel(const ProblemKind& kind, std::size_t side, std::string_view report) const {
  if (isVesc(config_))
    return {vescKind(kind), {static_cast<double>(config_.nodes[side]), vescs_[side].transistors()}, {kSides[side]}};
  const int node = config_.nodes[side];
  const auto id = [&](odrive::Command command) { return static_cast<double>(odrive::idOf(node, command)); };
  return {kind,
          {static_cast<double>(node), id(odrive::Command::kSetAxisState), id(odrive::Command::kClearErrors),
           id(odrive::Command::kControllerMode)},
          {kSides[side], report, config_.interface}};
}

Problem CanBase::noHeartbeat(std::size_t side) const {
  return ofWheel(config_.commands ? problem::kNoHeartbeatStops : problem::kNoHeartbeat, side);
}

Problem CanBase::notArmed(std::size_t side) const {
  return ofWheel(config_.commands ? problem::kNotArmedStops : problem::kNotArmed, side);
}

Problem CanBase::slowEstimates(std::size_t side) const {
  const double period = 10.0 * std::round(100.0 * toSeconds(wheels_.period(side)));  // [ms]
  return {isVesc(config_) ? problem::kVescSlow : problem::kSlowEstimates, {period}, {kSides[side]}};
}

Problem CanBase::axisError(std::size_t side) const {
  const odrive::Heartbeat axis = *axes_[side].usableHeartbeat();
  const bool armed = axis.state == static_cast<std::uint8_t>(odrive::AxisState::kClosedLoop);
  std::array<char, 64> report{};
  std::snprintf(report.data(), report.size(), "0x%x%s%s%s, %s", static_cast<unsigned>(axis.axis_error),
                axis.motor_error ? ", motor" : "", axis.encoder_error ? ", encoder" : "",
                axis.controller_error ? ", controller" : "", armed ? "still in closed loop" : "disarmed");
  return ofWheel(config_.commands ? problem::kAxisErrorStops : problem::kAxisError, side, report.data());
}

bool CanBase::obeys(std::size_t side, Timestamp now) const {
  const CanAxis& axis = axes_[side];
  const bool heartbeats = axis.heartbeat() > silence_.begin() && now - axis.heartbeat() <= axis.heartbeatPatience();
  // A drive that is gone is seen earliest by what it sends most often.
  const Duration period = wheels_.period(side);
  const bool silent = period > Duration(0) &&
                      now - std::max(axis.heartbeat(), axis.estimates()) > patienceFor(period, CanAxis::kFramesLost);
  // Where its heartbeats cannot be told from others, how its wheel turns is all that is known.
  const bool ready = !silent && (axis.isShared() || (heartbeats && axis.obeys()));
  return ready && follow_.idle() != side;
}

Problem CanBase::hindrance(std::size_t side) const {
  const CanAxis& axis = axes_[side];
  if (!axis.isShared()) {
    // Overdue when the last estimates came: a drive that is silent altogether is another matter.
    if (silence_.since(axis.heartbeat(), axis.estimates(), axis.heartbeatPatience())) return noHeartbeat(side);
    if (axis.lastHeartbeat() && !axis.inClosedLoop()) return notArmed(side);
  }
  return follow_.idle() == side ? ofWheel(problem::kNotFollowing, side) : Problem();
}

void CanBase::watchObedience(Timestamp now) {
  const bool measured = !silence_.since(axes_[0].estimates(), now, patience(0)) &&
                        !silence_.since(axes_[1].estimates(), now, patience(1));
  if (twist_ && measured)
    follow_.add(now, {axes_[0].velocity(), axes_[1].velocity()}, std::max(wheels_.period(0), wheels_.period(1)));
  else
    follow_.rest();
  const bool armed_anew =
      follow_.idle() && axes_[*follow_.idle()].lastHeartbeat() && !axes_[*follow_.idle()].inClosedLoop();
  if (armed_anew || now - command_.given() > kLetGo) follow_.forget();
  if (link_.usable() && obeys(0, now) && obeys(1, now)) return;
  command_.revoke(now);
  if (!twist_) return;
  twist_.reset();
  link_.dropWaiting();
  next_command_ = now;
}

void CanBase::watchImu(Timestamp now) {
  if (watchLink(imu_.status())) return;
  const auto [state, problem] = imu_.look(silence_, now);
  state == DeviceState::kStale ? setStale(imu_.status(), problem) : imu_.status().set(state, problem);
}

bool CanBase::command(const Twist2& twist, Timestamp given) { return config_.commands && command_.give(twist, given); }

/// Before anything is sent: a speed that has become too old while it waited for room must not go out.
void CanBase::takeCommand(Timestamp now) {
  const bool drove = twist_.has_value();
  twist_ = command_.at(now);
  if (drove && !twist_) link_.dropWaiting();
}

void CanBase::sendCommand(Timestamp now) {
  if (!config_.commands || !link_.usable() || now < next_command_) return;
  next_command_ = std::max(next_command_ + kCommandPeriod, now);
  sendSpeeds(now, twist_.value_or(Twist2{}));
}

/// Firmware 0.6 tells its version when asked; 0.5 never answers. Nothing is asked where nothing may be sent.
void CanBase::askVersions(Timestamp now) {
  if (!config_.commands || !link_.usable()) return;
  for (std::size_t side = 0; side < 2; ++side) {
    CanAxis& axis = axes_[side];
    if (silence_.since(axis.heartbeat(), now, kHeartbeatSilent)) axis.askAnew();
    if (axis.wantsVersion(now)) link_.send(odrive::requestVersion(config_.nodes[side]), now);
  }
}

void CanBase::stop() {
  Timestamp now = now_();
  for (int i = 0; i < kStopTries && config_.commands && link_.usable() && !sendSpeeds(now, Twist2{}); ++i) {
    std::this_thread::sleep_for(1ms);
    now += 1ms;
  }
  link_.close();
}

bool CanBase::sendSpeeds(Timestamp now, const Twist2& twist) {
  const double turn = config_.half_track * twist.omega;  // [m/s]
  std::array<double, 2> wheels = {(twist.vx - turn) / config_.wheel_radius, (twist.vx + turn) / config_.wheel_radius};
  const double fastest = std::max(std::abs(wheels[0]), std::abs(wheels[1]));  // [rad/s]
  const double factor = fastest > config_.wheel.max_speed ? config_.wheel.max_speed / fastest : 1.0;
  bool taken = false;
  for (std::size_t side = 0; side < 2; ++side) {
    const double turns = factor * wheels[side] / (2.0 * std::numbers::pi);
    const double velocity = turns * config_.wheel.gear_ratio * config_.wheel.sign[side] + 0.0;  // a zero without sign
    follow_.ask(side, velocity);
    taken = link_.send(isVesc(config_)
                           ? vescs_[side].encodeSpeed(velocity)
                           : odrive::encodeInputVelocity(config_.nodes[side], {static_cast<float>(velocity), 0.0F}),
                       now);
  }
  return taken;
}

}  // namespace slam
