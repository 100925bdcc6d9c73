// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus/publisher.hpp"

#include <string_view>
#include <utility>

#include "app/log/log.hpp"
#include "app/log/record_file.hpp"
#include "bus/channels.hpp"
#include "bus/messages.hpp"
#include "bus/restamp.hpp"

namespace slam {

Publisher::Publisher(const Config& config, const BusEnds& ends, const WallClock& clock)
    : ends_(ends), clock_(clock), map_refresh_(fromSeconds(config.lcm.map_refresh)), link_(config.lcm.url) {
  if (!config.output.record.empty())
    recorder_ = std::make_unique<Recorder>("record", std::make_unique<RecordFile>(config.output.record));
  if (!config.log.directory.empty()) {
    auto field_log = std::make_unique<FieldLog>(config, clock, [this] { ends_.wakeup.notify(); });
    field_log_ = field_log.get();
    log_ = std::make_unique<Recorder>("log", std::move(field_log));
  }
  link_.subscribe(channel::kSlamPose, [this](Bytes message) {
    takePoses();
    rivals_.received(message, monotonicNow());
  });
}

/// Recordings go on without a step of the clock: what is replayed goes by the stamps in it.
void Publisher::record(const std::string& channel, Bytes data) {
  const std::int64_t step = toMicroseconds(Timestamp(clock_.followed()));
  const std::int64_t utime = clock_.utime(monotonicNow()) - step;
  if (step != 0) data = restamped(data, utimeOf(data) - step, unstepped_);
  if (recorder_) recorder_->add(utime, channel, data);
  if (field_log_ != nullptr && field_log_->takes(channel)) log_->add(utime, channel, data);
}

void Publisher::takePoses() {
  ends_.poses.drain([this](const SentPose& pose) {
    if (field_log_ != nullptr) field_log_->setMap(pose.map_id);
    encodeEach(pose, buffer_, [&](const char* channel) {
      if (std::string_view(channel) == channel::kSlamPose) rivals_.sent(buffer_);
      link_.published(channel, buffer_, pose.before, pose.sent);
      record(channel, buffer_);
    });
  });
}

void Publisher::publishSamples() {
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

void Publisher::publishMap() {
  ends_.tiles.meta.drain([this](const map_meta_t& meta) { publish(channel::kMapMeta, meta); });
  ends_.tiles.map.drain([this](const map_tile_t& tile) { publish(channel::kMapTile, tile); });
  ends_.tiles.lidar.drain([this](const map_tile_t& tile) { publish(channel::kMapLidar, tile); });
  ends_.tiles.depth.drain([this](const map_tile_t& tile) { publish(channel::kMapDepth, tile); });
  ends_.edits.drain([this](const EditMessages& edits) {
    edits_ = edits;
    publishEdits();
  });
}

void Publisher::publishEdits() {
  if (!edits_) return;
  for (const map_edit_t& edit : *edits_) publish(channel::kMapEdits, edit);
}

void Publisher::publishHealth(LocalSocket& socket) {
  ends_.health.drain([&](const HealthReport& report) {
    publish(channel::kProblems, report.problems);
    socket.sendAll(channel::kProblems, buffer_);
    publish(channel::kHealth, report.health);
    socket.sendAll(channel::kHealth, buffer_);
  });
}

void Publisher::report(Timestamp now) {
  if (now >= next_refresh_) {
    next_refresh_ = now + map_refresh_;
    ends_.requests.refresh = true;
    publishEdits();
  }
  link_state_ = link_.state(now);
  rival_ = rivals_.hasRival(now);
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

}  // namespace slam
