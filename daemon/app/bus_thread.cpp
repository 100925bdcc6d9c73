// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus_thread.hpp"

#include <algorithm>
#include <cmath>
#include <poll.h>

#include "app/log.hpp"
#include "app/record_file.hpp"
#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/freshness.hpp"
#include "bus/messages.hpp"
#include "slam/ack_t.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr int kWait = 50;  // [ms] without a wake-up

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

}  // namespace

BusThread::BusThread(const Config& config, Exchange& exchange, const WallClock& clock)
    : config_(config),
      exchange_(exchange),
      clock_(clock),
      link_(config.lcm.url),
      socket_(config.runtime.socket),
      scan_(std::make_unique<ReceivedScan>()),
      worker_({.name = "bus"}, [this] { tick(); }) {
  if (!config.output.record.empty())
    recorder_ = std::make_unique<Recorder>("record", std::make_unique<RecordFile>(config.output.record));
  if (!config.log.directory.empty()) {
    auto field_log = std::make_unique<FieldLog>(config, clock, [this] { exchange_.bus_wakeup.notify(); });
    field_log_ = field_log.get();
    log_ = std::make_unique<Recorder>("log", std::move(field_log));
  }
  for (DeviceStatus* status : {&lidar_, &wheels_, &imu_, &depth_})
    status->set(DeviceState::kOpening, "waiting for messages on LCM");
  subscribe();
  socket_.tend(monotonicNow());  // so that it is there when systemd hears that slamd is
}

BusThread::~BusThread() { worker_.stop(); }

void BusThread::subscribe() {
  const auto subscribe = [this](bool wanted, const char* channel, void (BusThread::*handler)(Bytes)) {
    if (wanted) link_.subscribe(channel, [this, handler](Bytes message) { (this->*handler)(message); });
  };
  subscribe(config_.lidar_device.driver == "lcm", channel::kScan, &BusThread::onScan);
  subscribe(config_.base_device.driver == "lcm", channel::kWheels, &BusThread::onWheels);
  subscribe(config_.imu_device.driver == "lcm", channel::kImu, &BusThread::onImu);
  subscribe(config_.depth_device.driver == "lcm", channel::kDepth, &BusThread::onDepth);
  subscribe(config_.base_device.speed_commands, channel::kDrive, &BusThread::onDrive);
  if (config_.lcm.commands)
    link_.subscribe(channel::kCommand, [this](Bytes message) { onCommand(message, std::nullopt); });
  socket_.subscribe(channel::kCommand, [this](LocalSocket::Client from, Bytes message) { onCommand(message, from); });
}

void BusThread::tick() {
  pollfd waiting[] = {{exchange_.bus_wakeup.descriptor(), POLLIN, 0},
                      {link_.descriptor(), POLLIN, 0},
                      {socket_.descriptor(), POLLIN, 0}};
  ::poll(waiting, std::size(waiting), kWait);
  exchange_.bus_wakeup.clear();
  link_.receive();
  link_.tend(monotonicNow());
  socket_.receive();
  socket_.tend(monotonicNow());
  publishPose();
  publishRaw();
  acknowledgeSave();
  const auto acknowledge_all = [this](const MapAnswer& answer) {
    acknowledge(answer.id, answer.accepted, answer.message);
  };
  exchange_.map_answers.drain(acknowledge_all);
  if (field_log_ != nullptr) field_log_->answers().drain(acknowledge_all);
  exchange_.map_meta.drain([this](const map_meta_t& meta) { publish(channel::kMapMeta, meta); });
  exchange_.map_tiles.drain([this](const map_tile_t& tile) { publish(channel::kMapTile, tile); });
  exchange_.lidar_tiles.drain([this](const map_tile_t& tile) { publish(channel::kMapLidar, tile); });
  exchange_.depth_tiles.drain([this](const map_tile_t& tile) { publish(channel::kMapDepth, tile); });
  exchange_.health.drain([this](const health_t& health) {
    publish(channel::kHealth, health);
    socket_.sendAll(channel::kHealth, buffer_);
  });

  const Timestamp now = monotonicNow();
  if (now >= next_refresh_) {
    next_refresh_ = now + fromSeconds(config_.lcm.map_refresh);
    exchange_.refresh_map = true;
  }
  reportLink(now);
  reportSocket();
}

void BusThread::reportLink(Timestamp now) {
  link_state_ = link_.state(now);
  const PacketDispatcher& received = link_.received();
  exchange_.lcm_fragments = received.counts().fragments;
  exchange_.lcm_other_packets = received.counts().others;
  exchange_.lcm_dropped = link_.dropped();
  if (too_large_logged_ || received.tooLarge().empty()) return;
  too_large_logged_ = true;
  logWarning("LCM: a message on " + received.tooLarge() +
             " is larger than a datagram and is not read; fix: its sender must keep it below 65 kB");
}

void BusThread::reportSocket() {
  exchange_.socket_clients = socket_.clients();
  exchange_.socket_bad = socket_.counts().bad;
  exchange_.socket_dropped = socket_.counts().dropped;
  exchange_.socket_refused = socket_.counts().refused;
  if (socket_.problem() == socket_problem_.get()) return;
  socket_problem_.set(socket_.problem());
  socket_.problem().empty() ? logInfo(socket_.path() + ": commands are taken again") : logWarning(socket_.problem());
}

template <typename Message>
void BusThread::encode(const Message& message) {
  buffer_.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(buffer_.data(), 0, static_cast<int>(buffer_.size()));
}

template <typename Message>
void BusThread::publish(const char* channel, const Message& message) {
  encode(message);
  const bool sent = link_.publish(channel, buffer_, monotonicNow());
  ++(sent ? exchange_.published : exchange_.publish_failures);
  record(channel, buffer_);
}

void BusThread::record(const std::string& channel, Bytes data) {
  const std::int64_t utime = clock_.utime(monotonicNow());
  if (recorder_) recorder_->add(utime, channel, data);
  if (field_log_ != nullptr && field_log_->takes(channel)) log_->add(utime, channel, data);
}

void BusThread::publishPose() {
  if (!exchange_.pose_for_bus.load(snapshot_)) return;
  if (field_log_ != nullptr) field_log_->setMap(snapshot_.map_id);
  const std::int64_t utime = clock_.utime(snapshot_.pose.stamp);
  publish(channel::kOdometry, toMessage(snapshot_.odometry, utime));
  publish(channel::kSlamPose, toMessage(snapshot_.pose, utime, snapshot_.map_id));
  // POSE has no field for "not valid", so it is silent until there is a pose that is.
  const bool valid =
      snapshot_.pose.state == LocalisationState::kLocalised || snapshot_.pose.state == LocalisationState::kDegraded;
  if (valid) publish(channel::kPose, toPoseMessage(snapshot_.pose, utime));
  if (snapshot_.scans != scans_published_) {
    scans_published_ = snapshot_.scans;
    exchange_.scan_to_pose.add(monotonicNow() - snapshot_.scan_received);
  }
}

void BusThread::publishRaw() {
  exchange_.wheels_out.drain([this](const WheelReading& reading) {
    publish(channel::kWheels, toMessage(reading.sample, clock_.utime(reading.sample.stamp),
                                        {reading.angles.data(), static_cast<std::size_t>(reading.count)}));
  });
  exchange_.imu_out.drain(
      [this](const ImuSample& sample) { publish(channel::kImu, toMessage(sample, clock_.utime(sample.stamp))); });
  exchange_.scans_out.drain([this](const ReceivedScan& received) {
    const std::int64_t utime = clock_.utime(received.scan.stamp);
    publish(channel::kScan, toMessage(received.scan, utime));
    publish(channel::kLaser, toLaserMessage(received.scan, utime));
  });
  exchange_.views_out.drain(
      [this](const PseudoLaser& laser) { publish(channel::kDepth, toMessage(laser, clock_.utime(laser.stamp))); });
}

template <typename Message>
auto BusThread::receive(const char* channel, Bytes data, DeviceStatus& status, StampWords& words) {
  const auto message = decodeChecked<Message>(data);
  auto sample = message ? fromMessage(*message) : std::nullopt;
  const Timestamp now = monotonicNow();
  const char* wrong = "";
  if (sample) {
    sample->stamp = clock_.stamp(message->utime);
    wrong = words.of(now - sample->stamp);
    if (!isPossible(sample->stamp, now)) {
      sample.reset();
      status.reason = wrong;
    }
  }
  if (sample) {
    status.countSample(now);
    status.set(DeviceState::kStreaming, wrong);
    record(channel, data);
  } else {
    ++exchange_.bad_messages;
    status.rejects.fetch_add(1, std::memory_order_relaxed);
  }
  return sample;
}

void BusThread::onScan(Bytes data) {
  const auto scan = receive<scan_t>(channel::kScan, data, lidar_, lidar_stamps_);
  if (!scan) return;
  scan_->scan = *scan;
  scan_->received = monotonicNow();
  exchange_.scans.tryPush(*scan_);
  publish(channel::kLaser, toLaserMessage(*scan, clock_.utime(scan->stamp)));
}

void BusThread::onWheels(Bytes data) {
  if (const auto sample = receive<wheels_t>(channel::kWheels, data, wheels_, wheel_stamps_))
    exchange_.wheels.tryPush({*sample, {}, 0});
}

void BusThread::onImu(Bytes data) {
  if (const auto sample = receive<imu_t>(channel::kImu, data, imu_, imu_stamps_)) exchange_.imu.tryPush(*sample);
}

void BusThread::onDepth(Bytes data) {
  if (const auto laser = receive<depth_t>(channel::kDepth, data, depth_, depth_stamps_))
    exchange_.views.tryPush(*laser);
}

void BusThread::onDrive(Bytes data) {
  const auto message = decodeChecked<drive_t>(data);
  const auto twist = message ? fromMessage(*message) : std::nullopt;
  const Timestamp now = monotonicNow(), sent = twist ? clock_.stamp(message->utime) : Timestamp{};
  const bool fresh = twist && isFreshCommand(sent, now);
  if (twist) record(channel::kDrive, data);
  fresh ? void(exchange_.drives.tryPush({*twist, std::min(sent, now)})) : void(++exchange_.bad_messages);
}

void BusThread::acknowledgeSave() {
  const SaveOutcome outcome = exchange_.map_saved;
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
  const auto asked = asked_.extract(ticket);
  const Asker asker = asked ? asked.mapped() : Asker{std::nullopt, ticket};
  ack_t ack{};
  ack.utime = clock_.utime(monotonicNow());
  ack.id = asker.id;
  ack.accepted = accepted;
  ack.message = message;
  if (!asker.client) return publish(channel::kAck, ack);
  encode(ack);
  socket_.send(*asker.client, channel::kAck, buffer_);
}

void BusThread::onCommand(Bytes data, std::optional<LocalSocket::Client> from) {
  auto command = decodeChecked<command_t>(data);
  if (!command) {
    ++exchange_.bad_messages;
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
    exchange_.map_saved = SaveOutcome::kNone;
    saving_ = command->id;
    exchange_.save_map = true;
  } else if (command->verb == "set_pose") {
    if (!isFinite(pose)) return acknowledge(command->id, false, "the pose is not finite");
    const bool taken = exchange_.set_poses.tryPush({pose});
    acknowledge(command->id, taken, taken ? "pose set" : "too many commands at once");
  } else if (const auto map_command = mapCommandOf(*command)) {
    const bool taken = exchange_.map_commands.tryPush(*map_command);
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
