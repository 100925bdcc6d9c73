// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/serial_base.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kUnanswered = 250ms;  // nothing received: what the base does is not known any more
constexpr Duration kStale = 500ms;       // the same, worth a word
constexpr Duration kDead = 4s;           // then the port is opened anew; an Arduino boots for 2 s
constexpr Duration kDrivePeriod = 50ms;  // between two speeds
constexpr Duration kPutDown = 500ms;     // no wheel hangs for so long: hands are off it
constexpr Duration kEnd = 250ms;         // at the end, for the last zero to be known
constexpr Duration kEndStep = 10ms;
constexpr double kGeometryTolerance = 0.05;  // [1] a calibration may differ from the maker's figures by less
constexpr double kFastestWheel = 100.0;      // [rad/s] above what any motor of such a base can do
constexpr double kOverspeed = 2.0;           // [1] of the fastest, downhill or in the air

double fastestWheel(const BaseFacts& facts) {
  return facts.fastest > 0.0 ? kOverspeed * facts.fastest / facts.wheel_radius : kFastestWheel;
}

}  // namespace

SerialBase::SerialBase(const SerialBaseConfig& config, Clock now, Sinks sinks, const PortOpener& open)
    : config_(config),
      now_(now),
      sinks_(std::move(sinks)),
      port_(PortOf::kBoard, config.port, config.baud, config.in_background, open, config.facts->line_device,
            {&wheels_, &imu_}),
      protocol_(config.facts->make(config.robot)),
      take_([this](const BaseReading& reading) { take(reading); }),
      counted_(config.robot.counts_per_turn, config.facts->counter_bits, fastestWheel(*config.facts)),
      speeds_(config.robot.may_drive, config.limits, kDrivePeriod) {}

void SerialBase::tick() {
  const Timestamp now = now_();
  if (!port_.isOpen()) {
    if (port_.openWhenDue(now)) begin(now);
    return;
  }
  if (!receive(now)) return port_.lose(now);
  watch(now);
  if (port_.isOpen()) send(now);
}

void SerialBase::stop() {
  if (!port_.isOpen()) return;
  const Timestamp end = now_() + kEnd;
  for (Timestamp now = now_(); speeds_.isOwed() && now < end; now = now_()) {
    speeds_.revoke(now);
    send(now);
    if (!receive(now, kEndStep)) break;
  }
  if (config_.robot.may_drive) port_.write(protocol_->farewell().bytes());
  port_.close();
}

void SerialBase::begin(Timestamp now) {
  protocol_->begin(now);
  received_ = {.at = now, .byte = now, .turn_rate = now};
  speeds_.owe();
  for (DeviceStatus* status : {&wheels_, &imu_}) status->setOpening(problem::kBoardOpening);
}

bool SerialBase::receive(Timestamp now, Duration wait) {
  const bool open = port_.drain(
      [&](std::uint8_t byte) {
        received_.byte = now;
        protocol_->push(byte, now, take_);
      },
      wait);
  wheels_.rejects.store(protocol_->damage(), std::memory_order_relaxed);
  return open;
}

void SerialBase::take(const BaseReading& reading) {
  received_.at = now_();
  port_.succeeded();
  if (reading.battery) battery_ = *reading.battery;
  if (reading.lifted.value_or(false)) received_.lifted_until = received_.at + kPutDown;
  const bool obeyed = std::exchange(received_.obeys, reading.obeys.value_or(received_.obeys));
  if (obeyed && !received_.obeys) speeds_.revoke(received_.at);
  received_.bumped = reading.bumped.value_or(received_.bumped);
  if (reading.has_speed) speeds_.acknowledge();
  if (reading.counts || reading.turn_rate) emit(reading);
  if (!reading.fault) return;
  wheels_.set(DeviceState::kFault, reading.fault);
  speeds_.owe();
}

void SerialBase::emit(const BaseReading& reading) {
  if (reading.turn_rate && sinks_.imu) {
    sinks_.imu({reading.stamp, {0.0, 0.0, *reading.turn_rate}, Eigen::Vector3d::Zero()});
    imu_.countSample(reading.stamp);
    imu_.set(DeviceState::kStreaming);
    received_.turn_rate = received_.at;
  } else if (config_.gyro && reading.counts && received_.at - received_.turn_rate > kStale) {
    imu_.set(DeviceState::kAbsent, {problem::kBaseNoGyro, {}, {config_.facts->name}});
  }
  if (!reading.counts) return;
  if (reading.restarted) counted_.restart();
  sinks_.wheels(counted_.add(reading.stamp, *reading.counts, isLifted()));
  wheels_.countSample(reading.stamp);
  wheels_.set(DeviceState::kStreaming, isLifted()         ? Problem(problem::kBaseLifted)
                                       : !received_.obeys ? Problem(problem::kBaseLeftSafeMode)
                                       : received_.bumped ? Problem(problem::kBaseBumped)
                                                          : Problem());
}

void SerialBase::watch(Timestamp now) {
  const Duration silence = now - received_.at;
  if (silence > kUnanswered) speeds_.owe();
  if (silence > kDead) {
    const Problem undecoded(problem::kBaseUndecoded, {}, {config_.facts->name});
    return port_.giveUp(now, received_.isNoise() ? undecoded : problem::kBoardUnanswered);
  }
  if (silence <= kStale || wheels_.state == DeviceState::kOpening) return;
  port_.report(DeviceState::kStale, received_.isNoise() ? problem::kBoardGarbage : problem::kBoardSilent);
}

void SerialBase::send(Timestamp now) {
  if (const Outgoing question = protocol_->question(now); !question.empty()) port_.write(question.bytes());
  if (isLifted()) speeds_.revoke(now);
  if (!protocol_->takesSpeeds(now)) return;
  if (const std::optional<Twist2> twist = speeds_.due(now))
    port_.write(protocol_->speeds(sidesOf(*twist), now).bytes());
}

/// Both made slower by one factor where one is above what a wheel can do: so the curve stays.
SideSpeeds SerialBase::sidesOf(const Twist2& twist) const {
  const double turn = config_.robot.half_track * twist.omega;  // [m/s]
  const double left = twist.vx - turn, right = twist.vx + turn;
  const double fastest = std::max(std::abs(left), std::abs(right));
  const bool too_fast = config_.facts->fastest > 0.0 && fastest > config_.facts->fastest;
  const double factor = too_fast ? config_.facts->fastest / fastest : 1.0;
  return {factor * left, factor * right};
}

Problem SerialBase::finding() const {
  const auto differs = [](double makers, double set) {
    return makers > 0.0 && std::abs(set - makers) > kGeometryTolerance * makers;
  };
  const BaseFacts& facts = *config_.facts;
  if (!differs(facts.wheel_radius, config_.robot.wheel_radius) && !differs(facts.half_track, config_.robot.half_track))
    return {};
  return {problem::kBaseGeometry,
          {config_.robot.wheel_radius, config_.robot.half_track, facts.wheel_radius, facts.half_track},
          {facts.name}};
}

}  // namespace slam
