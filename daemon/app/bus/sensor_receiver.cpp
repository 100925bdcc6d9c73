// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus/sensor_receiver.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/freshness.hpp"
#include "bus/received.hpp"
#include "bus/restamp.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

/// [s] that a measurement goes on behind its stamp.
template <typename Sample>
Duration lengthOf(const Sample& sample) {
  if constexpr (std::is_same_v<Sample, LaserScan>) {
    float last = 0.0F;
    for (const Beam& beam : sample.beams()) last = std::max(last, beam.time_offset);
    return fromSeconds(static_cast<double>(last));
  }
  return Duration(0);
}

}  // namespace

template <typename Message>
auto SensorReceiver::receive(Bytes data, Sensor& sensor) {
  Received<Message> received(data);
  const Timestamp now = monotonicNow();
  Problem problem;
  if (received) {
    const Timestamp stamp = clock_.stamp(received.message->utime);
    const auto mapped = clocks_.map(sensor.stream, stamp, lengthOf(*received.sample), now);
    received.refusal = mapped.refusal;
    problem = stampProblem(mapped.age, mapped.differs);
    received.sample->stamp = stamp + mapped.shift;
    if (mapped.refusal != Refusal::kNone) received.sample.reset();
  }
  if (received.sample) {
    sensor.refusals.taken();
    if (const Refusal noted = sensor.refusals.noted(); noted != Refusal::kNone)
      problem = problemOf(noted, sensor.channel);
    if constexpr (std::is_same_v<Message, scan_t>) sensor.status.thinned += thinnedBeams(*received.message);
    sensor.status.countSample(now);
    sensor.status.set(DeviceState::kStreaming, problem);
    publisher_.record(sensor.channel, restamped(data, clock_.utime(received.sample->stamp), restamped_));
  } else {
    ends_.counters.refuse(received.refusal);
    sensor.refusals.refused(received.refusal);
    sensor.status.rejects.fetch_add(1, std::memory_order_relaxed);
    if (const Refusal noted = sensor.refusals.noted(); noted != Refusal::kNone)
      sensor.status.setProblem(problemOf(noted, sensor.channel));
  }
  return std::move(received.sample);
}

void SensorReceiver::onScan(Bytes data) {
  const auto scan = receive<scan_t>(data, lidar_);
  if (!scan) return;
  scan_->scan = *scan;
  scan_->received = monotonicNow();
  ends_.samples.scans.tryPush(*scan_);
  ends_.estimator_wakeup.notify();
  publisher_.publish(channel::kLaser, toLaserMessage(*scan, clock_.utime(scan->stamp)));
}

SensorReceiver::SensorReceiver(const Config& config, const BusEnds& ends, const WallClock& clock, Publisher& publisher)
    : ends_(ends),
      clock_(clock),
      publisher_(publisher),
      lidar_{channel::kScan, SenderClocks::kLidar},
      wheels_{channel::kWheels, SenderClocks::kWheels},
      imu_{channel::kImu, SenderClocks::kImu},
      depth_{channel::kDepth, SenderClocks::kDepth},
      scan_(std::make_unique<ReceivedScan>()) {
  for (Sensor* sensor : {&lidar_, &wheels_, &imu_, &depth_})
    sensor->status.set(DeviceState::kOpening, problem::kLcmOpening);
  LcmLink& link = publisher.link();
  if (config.lidar_device.driver == LidarDriver::kLcm)
    link.subscribe(channel::kScan, [this](Bytes data) { onScan(data); });
  if (config.base_device.driver == BaseDriver::kLcm) {
    link.subscribe(channel::kWheels, [this](Bytes data) {
      if (const auto sample = receive<wheels_t>(data, wheels_)) ends_.samples.wheels.tryPush({*sample, {}, 0});
    });
  }
  if (config.imu_device.driver == ImuDriver::kLcm) {
    link.subscribe(channel::kImu, [this](Bytes data) {
      if (const auto sample = receive<imu_t>(data, imu_)) ends_.samples.imu.tryPush(*sample);
    });
  }
  if (config.depth_device.driver == DepthDriver::kLcm) {
    link.subscribe(channel::kDepth, [this](Bytes data) {
      if (const auto laser = receive<depth_t>(data, depth_)) ends_.samples.views.tryPush(*laser);
    });
  }
}

DriveReceiver::DriveReceiver(const Config& config, const BusEnds& ends, const WallClock& clock, Publisher& publisher)
    : ends_(ends), clock_(clock), publisher_(publisher), senders_(config.base_device.drive_order) {
  if (config.base_device.speed_commands)
    publisher.link().subscribe(channel::kDrive, [this](Publisher::Bytes data) { onDrive(data); });
}

void DriveReceiver::sendOwedStop() {
  if (stop_owed_) stop_owed_ = !ends_.commands.drives.tryPush({{}, monotonicNow()});
}

void DriveReceiver::onDrive(Publisher::Bytes data) {
  const Received<drive_t> received(data);
  const Timestamp now = monotonicNow();
  const DriveSenders::Sender sender = publisher_.link().senderOfMessage();
  // A stop is obeyed whatever its stamp: it can come too late, and be meant for a drive before this one, but it harms
  // nobody.
  const auto& message = received.message;
  const bool zero = message && message->vx == 0.0 && message->vy == 0.0 && message->omega == 0.0;
  Refusal refusal = received.refusal;
  Timestamp sent = now;
  if (received) {
    const Timestamp stamp = clock_.stamp(message->utime);
    const auto mapped = senders_.clock(sender, now).map(SenderClocks::kDrive, stamp, Duration(0), now);
    sent = stamp + mapped.shift;
    stamps_ = stampProblem(mapped.age, mapped.differs);
    refusal = mapped.refusal;
    if (refusal == Refusal::kNone && !isFreshCommand(sent, now)) refusal = sent > now ? Refusal::kAhead : Refusal::kOld;
    publisher_.record(channel::kDrive, restamped(data, clock_.utime(zero ? now : sent), restamped_));
  }
  if (zero) {
    refusal = Refusal::kNone;
    senders_.take(sender, true, now);
    stop_owed_ = !ends_.commands.drives.tryPush({{}, now});
  } else if (refusal == Refusal::kNone && !stop_owed_ && senders_.take(sender, false, now)) {
    ends_.commands.drives.tryPush({*received.sample, std::min(sent, now)});
  } else if (refusal == Refusal::kNone) {
    ++ends_.counters.drives_not_followed;
  }
  if (refusal == Refusal::kNone) {
    refusals_.taken();
  } else {
    ends_.counters.refuse(refusal);
    refusals_.refused(refusal);
  }
}

/// Also while nothing comes: two that were told of may have become one.
void DriveReceiver::report(Timestamp now) {
  if (now >= next_senders_look_) {
    next_senders_look_ = now + 1s;  // who does what can change with each message
    several_ = senders_.problem(now);
  }
  const Refusal noted = refusals_.noted();
  problem_.set(several_ ? several_ : noted != Refusal::kNone ? problemOf(noted, channel::kDrive) : stamps_);
}

}  // namespace slam
