// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/serial_imu.hpp"

#include <algorithm>
#include <utility>

#include "core/plausibility.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kImuStale = 500ms;        // nothing that can be used
constexpr Duration kImuDead = 3s;            // then the port is opened anew
constexpr Duration kListen = 700ms;          // at one of several baud rates: two sets of a unit that sends at 10 Hz
constexpr Duration kWake = 300ms;            // a unit that sends nothing for so long is asked to ...
constexpr Duration kWakeAgain = 1s;          // ... and again
constexpr std::uint32_t kRecognisedImu = 3;  // good frames: a checksum may be right by chance, but not three

}  // namespace

SerialImu::SerialImu(const SerialImuConfig& config, Clock now, Sink sink, const PortOpener& open)
    : facts_(*config.facts),
      now_(now),
      sink_(std::move(sink)),
      port_(PortOf::kImu, config.port, config.baud > 0 ? config.baud : config.facts->bauds.front(),
            config.in_background, open, config.facts->line_device, {&status_}),
      protocol_(config.facts->make()),
      take_([this](const ImuSample& sample) { take(sample); }) {
  bauds_.all = facts_.bauds;
  bauds_.count = facts_.baudCount();
  if (config.baud > 0) bauds_.all.front() = config.baud, bauds_.count = 1;
}

void SerialImu::tick() {
  const Timestamp now = now_();
  if (!port_.isOpen()) {
    if (port_.openWhenDue(now)) begin(now);
    if (status_.state == DeviceState::kAbsent) bauds_.tried = 0;
    return;
  }
  if (!receive(now)) {
    bauds_.tried = 0;
    return port_.lose(now);
  }
  watch(now);
}

void SerialImu::begin(Timestamp now) {
  protocol_->begin(baud());
  const bool noise = bauds_.tried > 0 && received_.noise;  // at a baud rate before
  received_ = {.opened = now, .frame = now, .sample = now, .changed = now, .noise = noise};
  received_.frames = received_.last = protocol_->frames();
  received_.damage = protocol_->damage();
  status_.setOpening(Problem(problem::kWaitsForFrames, {}, {"the IMU's"}));
}

bool SerialImu::isRecognised() const { return protocol_->frames() - received_.frames >= kRecognisedImu; }

bool SerialImu::receive(Timestamp now) {
  const bool open = port_.drain([&](std::uint8_t byte) {
    received_.noise = true;
    protocol_->push(byte, now, take_);
    if (std::exchange(received_.last, protocol_->frames()) == protocol_->frames() || !isRecognised()) return;
    received_.frame = now;
    received_.noise = false;
    bauds_.tried = 0;
    bauds_.known = bauds_.at;
  });
  countRejects();
  return open;
}

void SerialImu::take(const ImuSample& sample) {
  if (!isRecognised()) return;
  countRejects();
  const Timestamp now = now_();
  const ImuSample& last = received_.value;
  // A unit without acceleration may calibrate its gyro to nothing at rest.
  const bool rests = sample.gyro.isZero() && sample.accel.isZero();
  if (!received_.has_sample || rests || sample.gyro != last.gyro || sample.accel != last.accel) received_.changed = now;
  if (now - received_.changed > kImuStale) {  // a real sensor never repeats itself for long
    received_.sample = now;
    return status_.set(DeviceState::kStale, problem::kImuFrozen);
  }
  if (!isPlausible(sample) || (received_.has_sample && sample.stamp <= last.stamp)) {
    received_.senseless = true;
    status_.rejects.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  received_.value = sample;
  if (!received_.has_sample && *protocol_->identity() != '\0') status_.identify(protocol_->identity());
  received_.has_sample = true;
  received_.senseless = false;
  received_.sample = now;
  sink_(sample);
  status_.countSample(now);
  status_.set(DeviceState::kStreaming, protocol_->finding());
  port_.succeeded();
}

void SerialImu::countRejects() {
  const std::uint32_t damage = protocol_->damage();
  // What comes before the unit is known was begun before the port was opened, or is at another baud rate.
  if (isRecognised() && damage > received_.damage) {
    received_.senseless = true;
    status_.rejects.fetch_add(damage - received_.damage, std::memory_order_relaxed);
  }
  received_.damage = damage;
}

Problem SerialImu::about(const ProblemKind& kind) const {
  return {kind, {}, {facts_.name, facts_.silence, facts_.output}};
}

/// @return whether the port is closed now, for another baud rate
bool SerialImu::tryNextBaud(Timestamp now) {
  if (bauds_.count < 2 || isRecognised() || now - received_.opened < kListen) return false;
  if (bauds_.next()) {
    port_.reopen(baud());
  } else {
    port_.useBaud(baud());
    giveUp(now);
  }
  return true;
}

/// For a while; meanwhile somebody else is looked for on the port.
void SerialImu::giveUp(Timestamp now) {
  bauds_.tried = 0;
  port_.giveUp(now, about(received_.noise ? problem::kImuUndecoded : problem::kImuUnanswered));
}

void SerialImu::watch(Timestamp now) {
  const Duration silence = now - std::max(received_.opened, received_.frame);
  if (!received_.noise && silence > kWake && now - received_.asked > kWakeAgain) {
    received_.asked = now;
    if (const Outgoing question = protocol_->wakeUp(); !question.empty()) port_.write(question.bytes());
  }
  if (tryNextBaud(now)) return;
  if (silence > kImuDead) return giveUp(now);
  if (silence <= kImuStale) return watchSamples(now);
  if (bauds_.count > 1 && !isRecognised()) return;  // it is still looked for
  port_.report(DeviceState::kStale, received_.noise ? Problem(problem::kImuGarbage) : about(problem::kImuSilent));
}

/// Frames come, but do they make samples?
void SerialImu::watchSamples(Timestamp now) {
  if (!isRecognised() || now - received_.sample <= kImuDead / 2) return;
  status_.set(DeviceState::kStale, received_.senseless ? Problem(problem::kImuSenseless) : about(problem::kImuNoRate));
}

}  // namespace slam
