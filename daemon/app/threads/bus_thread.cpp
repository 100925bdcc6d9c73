// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/bus_thread.hpp"

#include <algorithm>
#include <cmath>
#include <poll.h>
#include <string_view>
#include <type_traits>
#include <utility>

#include "app/log/log.hpp"
#include "app/log/record_file.hpp"
#include "app/threads/pose_messages.hpp"
#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/freshness.hpp"
#include "bus/messages.hpp"
#include "bus/received.hpp"
#include "bus/restamp.hpp"
#include "core/plausibility.hpp"
#include "slam/ack_t.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr int kWait = 50;                  // [ms] without a wake-up
constexpr Duration kClockSetBack = 500ms;  // more than a clock is slewed by at once

/// @return std::nullopt for what is no command about the map, or no mode
std::optional<MapCommand> mapCommandOf(const command_t& command) {
  const std::string &verb = command.verb, &argument = command.argument;
  if (verb == "save") return MapCommand{MapCommand::kSave, command.id, argument};
  if (verb == "load") return MapCommand{MapCommand::kLoad, command.id, argument};
  if (verb == "reset") return MapCommand{MapCommand::kReset, command.id, argument};
  if (verb == "mode" && argument == "slam") return MapCommand{MapCommand::kSlam, command.id, ""};
  if (verb == "mode" && argument == "localise") return MapCommand{MapCommand::kLocalise, command.id, ""};
  return std::nullopt;
}

std::optional<LogCommand> logCommandOf(const command_t& command) {
  if (command.verb == "log_start") return LogCommand{LogCommand::kStart, command.id, command.argument};
  if (command.verb == "log_stop") return LogCommand{LogCommand::kStop, command.id, command.argument};
  if (command.verb == "log_mark") return LogCommand{LogCommand::kMark, command.id, command.argument};
  return std::nullopt;
}

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

BusThread::BusThread(const Config& config, const BusEnds& ends, const WallClock& clock)
    : config_(config),
      ends_(ends),
      clock_(clock),
      link_(config.lcm.url),
      socket_(config.runtime.socket),
      scan_(std::make_unique<ReceivedScan>()),
      lidar_{channel::kScan, SenderClocks::kLidar},
      wheels_{channel::kWheels, SenderClocks::kWheels},
      imu_{channel::kImu, SenderClocks::kImu},
      depth_{channel::kDepth, SenderClocks::kDepth},
      drive_senders_(config.base_device.drive_order),
      worker_({.name = "bus"}, [this] { tick(); }) {
  if (!config.output.record.empty())
    recorder_ = std::make_unique<Recorder>("record", std::make_unique<RecordFile>(config.output.record));
  if (!config.log.directory.empty()) {
    auto field_log = std::make_unique<FieldLog>(config, clock, [this] { ends_.wakeup.notify(); });
    field_log_ = field_log.get();
    log_ = std::make_unique<Recorder>("log", std::move(field_log));
  }
  for (Sensor* sensor : {&lidar_, &wheels_, &imu_, &depth_})
    sensor->status.set(DeviceState::kOpening, problem::kLcmOpening);
  subscribe();
  socket_.tend(monotonicNow());  // so that it is there when systemd hears that slamd is
}

BusThread::~BusThread() { worker_.stop(); }

void BusThread::subscribe() {
  const auto subscribe = [this](bool wanted, const char* channel, void (BusThread::*handler)(Bytes)) {
    if (wanted) link_.subscribe(channel, [this, handler](Bytes message) { (this->*handler)(message); });
  };
  subscribe(config_.lidar_device.driver == LidarDriver::kLcm, channel::kScan, &BusThread::onScan);
  subscribe(config_.base_device.driver == BaseDriver::kLcm, channel::kWheels, &BusThread::onWheels);
  subscribe(config_.imu_device.driver == ImuDriver::kLcm, channel::kImu, &BusThread::onImu);
  subscribe(config_.depth_device.driver == DepthDriver::kLcm, channel::kDepth, &BusThread::onDepth);
  subscribe(config_.base_device.speed_commands, channel::kDrive, &BusThread::onDrive);
  link_.subscribe(channel::kSlamPose, [this](Bytes message) {
    takePoses();
    rivals_.heard(message, monotonicNow());
  });
  if (config_.lcm.commands)
    link_.subscribe(channel::kCommand, [this](Bytes message) { onCommand(message, std::nullopt); });
  socket_.subscribe(channel::kCommand, [this](LocalSocket::Client from, Bytes message) { onCommand(message, from); });
}

void BusThread::tick() {
  pollfd waiting[] = {
      {ends_.wakeup.descriptor(), POLLIN, 0}, {link_.descriptor(), POLLIN, 0}, {socket_.descriptor(), POLLIN, 0}};
  ::poll(waiting, std::size(waiting), kWait);
  ends_.wakeup.clear();
  takePoses();
  followClock();
  if (stop_owed_) stop_owed_ = !ends_.commands.drives.tryPush({{}, monotonicNow()});
  link_.receive();
  link_.tend(monotonicNow());
  socket_.receive();
  socket_.tend(monotonicNow());
  publishRaw();
  acknowledgeSave();
  const auto acknowledge_all = [this](const MapAnswer& answer) {
    acknowledge(answer.id, answer.accepted, answer.message);
  };
  ends_.answers.drain(acknowledge_all);
  if (field_log_ != nullptr) field_log_->answers().drain(acknowledge_all);
  ends_.tiles.meta.drain([this](const map_meta_t& meta) { publish(channel::kMapMeta, meta); });
  ends_.tiles.map.drain([this](const map_tile_t& tile) { publish(channel::kMapTile, tile); });
  ends_.tiles.lidar.drain([this](const map_tile_t& tile) { publish(channel::kMapLidar, tile); });
  ends_.tiles.depth.drain([this](const map_tile_t& tile) { publish(channel::kMapDepth, tile); });
  ends_.health.drain([this](const HealthReport& report) {
    publish(channel::kProblems, report.problems);
    socket_.sendAll(channel::kProblems, buffer_);
    publish(channel::kHealth, report.health);
    socket_.sendAll(channel::kHealth, buffer_);
  });

  const Timestamp now = monotonicNow();
  if (now >= next_refresh_) {
    next_refresh_ = now + fromSeconds(config_.lcm.map_refresh);
    ends_.requests.refresh = true;
  }
  reportLink(now);
  reportSocket();
  reportRival(now);
  reportDrives(now);
}

void BusThread::reportLink(Timestamp now) {
  link_state_ = link_.state(now);
  const PacketDispatcher& received = link_.received();
  ends_.counters.messages = received.counts().messages;
  ends_.counters.fragments = received.counts().fragments;
  ends_.counters.other_packets = received.counts().others;
  ends_.counters.dropped = link_.dropped();
  if (too_large_logged_ || received.tooLarge().empty()) return;
  too_large_logged_ = true;
  logWarning("LCM: a message on " + received.tooLarge() +
             " is larger than a datagram and is not read; fix: its sender must keep it below 65 kB");
}

void BusThread::reportSocket() {
  ends_.counters.socket_clients = socket_.clients();
  ends_.counters.socket_bad = socket_.counts().bad;
  ends_.counters.socket_dropped = socket_.counts().dropped;
  ends_.counters.socket_refused = socket_.counts().refused;
  socket_problem_.set(socket_.problem());
}

void BusThread::reportRival(Timestamp now) { rival_ = rivals_.hasRival(now); }

template <typename Message>
void BusThread::publish(const char* channel, const Message& message) {
  encode(message, buffer_);
  const bool sent = link_.publish(channel, buffer_, monotonicNow());
  ++(sent ? ends_.counters.published : ends_.counters.failures);
  record(channel, buffer_);
}

/// Recordings go on without a step of the clock: what is replayed goes by the stamps in it.
void BusThread::record(const std::string& channel, Bytes data) {
  const std::int64_t step = toMicroseconds(Timestamp(clock_.followed()));
  const std::int64_t utime = clock_.utime(monotonicNow()) - step;
  if (step != 0) data = restamped(data, utimeOf(data) - step, unstepped_);
  if (recorder_) recorder_->add(utime, channel, data);
  if (field_log_ != nullptr && field_log_->takes(channel)) log_->add(utime, channel, data);
}

void BusThread::takePoses() {
  ends_.poses.drain([this](const SentPose& pose) {
    if (field_log_ != nullptr) field_log_->setMap(pose.map_id);
    encodeEach(pose, buffer_, [&](const char* channel) {
      if (std::string_view(channel) == channel::kSlamPose) rivals_.sent(buffer_);
      link_.published(channel, buffer_, pose.before, pose.sent);
      record(channel, buffer_);
    });
  });
}

void BusThread::publishRaw() {
  ends_.raw.wheels.drain([this](const WheelReading& reading) {
    publish(channel::kWheels, toMessage(reading.sample, clock_.utime(reading.sample.stamp),
                                        {reading.angles.data(), static_cast<std::size_t>(reading.count)}));
  });
  ends_.raw.imu.drain(
      [this](const ImuSample& sample) { publish(channel::kImu, toMessage(sample, clock_.utime(sample.stamp))); });
  ends_.raw.scans.drain([this](const ReceivedScan& received) {
    const std::int64_t utime = clock_.utime(received.scan.stamp);
    publish(channel::kScan, toMessage(received.scan, utime));
    publish(channel::kLaser, toLaserMessage(received.scan, utime));
  });
  ends_.raw.views.drain(
      [this](const PseudoLaser& laser) { publish(channel::kDepth, toMessage(laser, clock_.utime(laser.stamp))); });
}

/// What is known of others' clocks counts from ours.
void BusThread::followClock() {
  const Duration drift = clock_.drift(), ahead = drift < -kClockSetBack ? -drift : Duration(0);
  const bool set = std::chrono::abs(ahead - ahead_) > kClockSetBack;
  if (set) ahead_ = ahead;
  if (std::exchange(followed_, clock_.followed()) == followed_ && !set) return;
  clocks_.begin(ahead_);
  drive_senders_.beginClocks(ahead_);
}

void BusThread::refuse(Refusal refusal) {
  ++ends_.counters.bad_messages;
  ++ends_.counters.refused[static_cast<std::size_t>(refusal) - 1];
}

template <typename Message>
auto BusThread::receive(Bytes data, Sensor& sensor) {
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
    record(sensor.channel, restamped(data, clock_.utime(received.sample->stamp), restamped_));
  } else {
    refuse(received.refusal);
    sensor.refusals.refused(received.refusal);
    sensor.status.rejects.fetch_add(1, std::memory_order_relaxed);
    if (const Refusal noted = sensor.refusals.noted(); noted != Refusal::kNone)
      sensor.status.setProblem(problemOf(noted, sensor.channel));
  }
  return std::move(received.sample);
}

void BusThread::onScan(Bytes data) {
  const auto scan = receive<scan_t>(data, lidar_);
  if (!scan) return;
  scan_->scan = *scan;
  scan_->received = monotonicNow();
  ends_.samples.scans.tryPush(*scan_);
  ends_.estimator_wakeup.notify();
  publish(channel::kLaser, toLaserMessage(*scan, clock_.utime(scan->stamp)));
}

void BusThread::onWheels(Bytes data) {
  if (const auto sample = receive<wheels_t>(data, wheels_)) ends_.samples.wheels.tryPush({*sample, {}, 0});
}

void BusThread::onImu(Bytes data) {
  if (const auto sample = receive<imu_t>(data, imu_)) ends_.samples.imu.tryPush(*sample);
}

void BusThread::onDepth(Bytes data) {
  if (const auto laser = receive<depth_t>(data, depth_)) ends_.samples.views.tryPush(*laser);
}

void BusThread::onDrive(Bytes data) {
  const Received<drive_t> received(data);
  const Timestamp now = monotonicNow();
  const DriveSenders::Sender sender = link_.senderOfMessage();
  // A stop is obeyed whatever its stamp: it can come too late, and be meant for a drive before this one, but it harms
  // nobody.
  const auto& message = received.message;
  const bool zero = message && message->vx == 0.0 && message->vy == 0.0 && message->omega == 0.0;
  Refusal refusal = received.refusal;
  Timestamp sent = now;
  if (received) {
    const Timestamp stamp = clock_.stamp(message->utime);
    const auto mapped = drive_senders_.clock(sender, now).map(SenderClocks::kDrive, stamp, Duration(0), now);
    sent = stamp + mapped.shift;
    drive_stamps_ = stampProblem(mapped.age, mapped.differs);
    refusal = mapped.refusal;
    if (refusal == Refusal::kNone && !isFreshCommand(sent, now)) refusal = sent > now ? Refusal::kAhead : Refusal::kOld;
    record(channel::kDrive, restamped(data, clock_.utime(zero ? now : sent), restamped_));
  }
  if (zero) {
    refusal = Refusal::kNone;
    drive_senders_.take(sender, true, now);
    stop_owed_ = !ends_.commands.drives.tryPush({{}, now});
  } else if (refusal == Refusal::kNone && !stop_owed_ && drive_senders_.take(sender, false, now)) {
    ends_.commands.drives.tryPush({*received.sample, std::min(sent, now)});
  } else if (refusal == Refusal::kNone) {
    ++ends_.counters.drives_not_followed;
  }
  if (refusal == Refusal::kNone) {
    drives_.taken();
  } else {
    refuse(refusal);
    drives_.refused(refusal);
  }
}

/// Also while nothing comes: two that were told of may have become one.
void BusThread::reportDrives(Timestamp now) {
  if (now >= next_senders_look_) {
    next_senders_look_ = now + 1s;  // who does what can change with each message
    several_senders_ = drive_senders_.problem(now);
  }
  const bool refused = drives_.noted() != Refusal::kNone;
  drive_problem_.set(several_senders_ ? several_senders_
                     : refused        ? problemOf(drives_.noted(), channel::kDrive)
                                      : drive_stamps_);
}

void BusThread::acknowledgeSave() {
  const SaveOutcome outcome = ends_.requests.saved;
  if (!saving_ || outcome == SaveOutcome::kNone) return;
  const bool saved = outcome == SaveOutcome::kSaved;
  acknowledge(*saving_, saved, saved ? "saved to " + config_.output.map + ".yaml" : "not saved; the log says why");
  saving_.reset();
}

std::int32_t BusThread::ticketFor(const Asker& asker) {
  constexpr std::size_t kMostOpen = 256;  // more than all queues hold: those were never answered
  if (asked_.size() >= kMostOpen) asked_.erase(asked_.begin());
  const auto ticket = static_cast<std::int32_t>(next_ticket_++);
  asked_[ticket] = asker;
  return ticket;
}

void BusThread::acknowledge(std::int32_t ticket, bool accepted, const std::string& message) {
  if (!accepted) ++ends_.counters.refused_commands;
  const auto asked = asked_.extract(ticket);
  const Asker asker = asked ? asked.mapped() : Asker{std::nullopt, ticket};
  ack_t ack{};
  ack.utime = clock_.utime(monotonicNow());
  ack.id = asker.id;
  ack.accepted = accepted;
  ack.message = message;
  if (!asker.client) return publish(channel::kAck, ack);
  encode(ack, buffer_);
  socket_.send(*asker.client, channel::kAck, buffer_);
}

void BusThread::onCommand(Bytes data, std::optional<LocalSocket::Client> from) {
  auto command = decodeChecked<command_t>(data);
  if (!command) {
    ++ends_.counters.bad_messages;
    return;
  }
  record(channel::kCommand, data);
  command->id = ticketFor({from, command->id});
  const Pose2 pose{command->pose[0], command->pose[1], command->pose[2]};
  if (command->verb == "save_map") {
    if (config_.output.map.empty())
      return acknowledge(command->id, false, "output.map is not set in the configuration");
    if (!command->argument.empty()) return acknowledge(command->id, false, "the place is output.map; give no argument");
    if (saving_) return acknowledge(command->id, false, "a map is being saved already");
    ends_.requests.saved = SaveOutcome::kNone;
    saving_ = command->id;
    ends_.requests.save = true;
  } else if (command->verb == "set_pose") {
    if (const std::string words = implausibilityOf(pose); !words.empty())
      return acknowledge(
          command->id, false,
          words + "; the pose stays as it was; give x and y in metres from the map's origin, theta in radians");
    const bool taken = ends_.commands.set_poses.tryPush({pose});
    acknowledge(command->id, taken, taken ? "pose set" : "too many commands at once");
  } else if (const auto map_command = mapCommandOf(*command)) {
    const bool taken = ends_.commands.map.tryPush(*map_command);
    if (!taken) acknowledge(command->id, false, "too many commands at once");  // otherwise the graph thread answers
  } else if (command->verb == "mode") {
    acknowledge(command->id, false, "a mode is slam or localise");
  } else if (command->verb.starts_with("log_")) {
    onLogCommand(*command);
  } else {
    acknowledge(command->id, false,
                "unknown verb; known are save, load, set_pose, reset, mode, save_map, log_start, log_stop, log_mark");
  }
}

void BusThread::onLogCommand(const command_t& command) {
  if (field_log_ == nullptr) return acknowledge(command.id, false, "log.directory is not set in the configuration");
  const auto wanted = logCommandOf(command);
  if (!wanted) return acknowledge(command.id, false, "unknown verb; known are log_start, log_stop, log_mark");
  if (wanted->kind == LogCommand::kMark && wanted->what.empty())
    return acknowledge(command.id, false, "say what has happened: log_mark needs an argument");
  if (!field_log_->command(*wanted)) acknowledge(command.id, false, "too many commands at once");
}

}  // namespace slam
