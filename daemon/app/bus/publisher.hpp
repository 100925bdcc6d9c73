// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/channels.hpp"
#include "app/log/field_log.hpp"
#include "app/log/recorder.hpp"
#include "app/threads/pose_messages.hpp"
#include "bus/local_socket.hpp"
#include "bus/rival_watch.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "config/config.hpp"
#include "runtime/clock.hpp"

namespace slam {

/// Publishes over LCM what the threads hand over, and keeps it in the record and the field log, if there are any.
/// Belongs to the bus thread.
class Publisher {
 public:
  using Bytes = std::span<const std::uint8_t>;

  Publisher(const Config& config, const BusEnds& ends, const WallClock& clock);

  /// Poses, which their thread has sent already, before any other message is handled.
  void takePoses();
  void publishSamples();
  void publishMap();
  /// Also to who is connected to the socket.
  void publishHealth(LocalSocket& socket);
  template <typename Message>
  void publish(const char* channel, const Message& message) {
    encode(message, buffer_);
    const bool sent = link_.publish(channel, buffer_, monotonicNow());
    ++(sent ? ends_.counters.published : ends_.counters.failures);
    record(channel, buffer_);
  }
  void record(const std::string& channel, Bytes data);
  /// Counters and states for others.
  void report(Timestamp now);

  LcmLink& link() { return link_; }
  const LcmLink& link() const { return link_; }
  Recorder* recorder() const { return recorder_.get(); }  ///< nullptr where nothing is recorded
  Recorder* logRecorder() const { return log_.get(); }    ///< nullptr where nothing is logged
  FieldLog* fieldLog() const { return field_log_; }       ///< of logRecorder()
  LinkState linkState() const { return link_state_; }     ///< from any thread
  bool hasRival() const { return rival_; }                ///< somebody else publishes SLAM_POSE too; from any thread

 private:
  void publishEdits();
  const BusEnds& ends_;
  const WallClock& clock_;
  const Duration map_refresh_;
  LcmLink link_;
  RivalWatch rivals_;  // on SLAM_POSE
  std::atomic<bool> rival_{false};
  std::atomic<LinkState> link_state_{LinkState::kOpening};
  std::unique_ptr<Recorder> recorder_, log_;
  FieldLog* field_log_ = nullptr;  // of log_
  bool too_large_logged_ = false;
  EditMessages edits_;
  Timestamp next_refresh_{};
  std::vector<std::uint8_t> buffer_, unstepped_;
};

}  // namespace slam
