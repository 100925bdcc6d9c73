// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <slam/command_t.hpp>
#include <span>
#include <string>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "app/field_log.hpp"
#include "app/recorder.hpp"
#include "bus/lcm_link.hpp"
#include "bus/local_socket.hpp"
#include "bus/stamp_words.hpp"
#include "drivers/device_status.hpp"
#include "runtime/clock.hpp"
#include "runtime/shared_text.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *bus*: everything that touches LCM or the local socket. Publishes, takes commands, and takes samples of
/// sensors whose driver is "lcm". Without a network it keeps trying; whatever is published, and what it takes, also
/// goes into the record and the field log, if there are any.
class BusThread {
 public:
  BusThread(const Config& config, Exchange& exchange, const WallClock& clock);
  ~BusThread();
  Worker& worker() { return worker_; }

  Recorder* recorder() const { return recorder_.get(); }  ///< nullptr where nothing is recorded
  Recorder* logRecorder() const { return log_.get(); }    ///< nullptr where nothing is logged
  FieldLog* fieldLog() const { return field_log_; }       ///< of logRecorder()
  LinkState linkState() const { return link_state_; }
  const UdpmUrl& url() const { return link_.url(); }
  std::string socketProblem() const { return socket_problem_.get(); }  ///< in words; empty: none
  DeviceStatus& lidarStatus() { return lidar_; }                       ///< of a lidar that comes over LCM
  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  DeviceStatus& depthStatus() { return depth_; }

 private:
  using Bytes = std::span<const std::uint8_t>;
  /// Who sent a command, and its number there: two may choose the same.
  struct Asker {
    std::optional<LocalSocket::Client> client;  ///< none: it came over LCM
    std::int32_t id = 0;
  };

  void tick();
  void subscribe();
  void reportLink(Timestamp now);
  void reportSocket();
  void publishPose();
  void publishRaw();
  template <typename Message>
  void encode(const Message& message);  ///< into buffer_
  template <typename Message>
  void publish(const char* channel, const Message& message);
  void acknowledgeSave();
  void record(const std::string& channel, Bytes data);
  /// @param ticket of the command, as ticketFor() gave it
  void acknowledge(std::int32_t ticket, bool accepted, const std::string& message);
  std::int32_t ticketFor(const Asker& asker);

  /// Decodes a sensor message and logs it; what cannot be one is counted. @return the sample, its stamp in our time
  template <typename Message>
  auto receive(const char* channel, Bytes data, DeviceStatus& status, StampWords& words);
  void onScan(Bytes data);
  void onWheels(Bytes data);
  void onImu(Bytes data);
  void onDepth(Bytes data);
  void onDrive(Bytes data);
  void onCommand(Bytes data, std::optional<LocalSocket::Client> from);
  void onLogCommand(const command_t& command);

  const Config& config_;
  Exchange& exchange_;
  const WallClock& clock_;
  LcmLink link_;
  LocalSocket socket_;
  SharedText socket_problem_;
  std::map<std::int32_t, Asker> asked_;  // by the tickets of commands that are not answered yet
  std::uint32_t next_ticket_ = 1;
  std::unique_ptr<Recorder> recorder_, log_;
  FieldLog* field_log_ = nullptr;  // of log_
  std::atomic<LinkState> link_state_{LinkState::kOpening};
  bool too_large_logged_ = false;
  Timestamp next_refresh_{};
  std::optional<std::int32_t> saving_;  // ticket of a save_map command that the mapper works on
  PoseSnapshot snapshot_;
  std::int64_t scans_published_ = 0;
  std::unique_ptr<ReceivedScan> scan_;
  std::vector<std::uint8_t> buffer_;
  DeviceStatus lidar_, wheels_, imu_, depth_;
  StampWords lidar_stamps_, wheel_stamps_, imu_stamps_, depth_stamps_;
  Worker worker_;
};

}  // namespace slam
