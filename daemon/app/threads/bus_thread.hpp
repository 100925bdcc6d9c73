// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <slam/command_t.hpp>
#include <span>
#include <string>

#include "app/channels.hpp"
#include "app/log/field_log.hpp"
#include "app/log/recorder.hpp"
#include "bus/drive_senders.hpp"
#include "bus/local_socket.hpp"
#include "bus/refusal.hpp"
#include "bus/rival_watch.hpp"
#include "bus/sender_clock.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "config/config.hpp"
#include "drivers/device_status.hpp"
#include "runtime/clock.hpp"
#include "runtime/shared_value.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *bus*: everything that touches LCM or the local socket. Publishes, takes commands, and takes samples of
/// sensors whose driver is "lcm". Without a network it keeps trying; whatever is published, and what it takes, also
/// goes into the record and the field log, if there are any.
class BusThread {
 public:
  BusThread(const Config& config, const BusEnds& ends, const WallClock& clock);
  ~BusThread();
  Worker& worker() { return worker_; }

  Recorder* recorder() const { return recorder_.get(); }  ///< nullptr where nothing is recorded
  Recorder* logRecorder() const { return log_.get(); }    ///< nullptr where nothing is logged
  FieldLog* fieldLog() const { return field_log_; }       ///< of logRecorder()
  LinkState linkState() const { return link_state_; }
  const UdpmUrl& url() const { return link_.url(); }
  Problem socketProblem() const { return socket_problem_.get(); }
  bool hasRival() const { return rival_; }  ///< somebody else publishes SLAM_POSE too
  LcmSender& poseSender() { return link_.sender(); }
  DeviceStatus& lidarStatus() { return lidar_.status; }  ///< of a lidar that comes over LCM
  DeviceStatus& wheelStatus() { return wheels_.status; }
  DeviceStatus& imuStatus() { return imu_.status; }
  DeviceStatus& depthStatus() { return depth_.status; }
  Problem commandProblem() const { return drive_problem_.get(); }  ///< with speeds that come over LCM

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
  void reportRival(Timestamp now);
  void reportDrives(Timestamp now);
  void takePoses();
  void publishRaw();
  template <typename Message>
  void publish(const char* channel, const Message& message);
  void acknowledgeSave();
  void record(const std::string& channel, Bytes data);
  /// @param ticket of the command, as ticketFor() gave it
  void acknowledge(std::int32_t ticket, bool accepted, const std::string& message);
  std::int32_t ticketFor(const Asker& asker);

  /// A sensor that comes over LCM.
  struct Sensor {
    const char* channel;
    SenderClocks::Stream stream;
    DeviceStatus status = {};
    RefusalNote refusals = {};
  };
  /// Decodes a sensor message and records it; what cannot be one is counted. @return the sample, its stamp in our time
  template <typename Message>
  auto receive(Bytes data, Sensor& sensor);
  void refuse(Refusal refusal);
  void followClock();
  void onScan(Bytes data);
  void onWheels(Bytes data);
  void onImu(Bytes data);
  void onDepth(Bytes data);
  void onDrive(Bytes data);
  void onCommand(Bytes data, std::optional<LocalSocket::Client> from);
  void onLogCommand(const command_t& command);

  const Config& config_;
  const BusEnds ends_;
  const WallClock& clock_;
  LcmLink link_;
  LocalSocket socket_;
  SharedValue<Problem> socket_problem_;
  RivalWatch rivals_;  // on SLAM_POSE
  std::atomic<bool> rival_{false};
  std::map<std::int32_t, Asker> asked_;  // by the tickets of commands that are not answered yet
  std::uint32_t next_ticket_ = 1;
  std::unique_ptr<Recorder> recorder_, log_;
  FieldLog* field_log_ = nullptr;  // of log_
  std::atomic<LinkState> link_state_{LinkState::kOpening};
  bool too_large_logged_ = false;
  Timestamp next_refresh_{};
  std::optional<std::int32_t> saving_;  // ticket of a save_map command that the mapper works on
  std::unique_ptr<ReceivedScan> scan_;
  std::vector<std::uint8_t> buffer_;
  std::vector<std::uint8_t> restamped_, unstepped_;
  SenderClocks clocks_;
  Duration followed_{0};  // by clock_, when clocks_ began
  Duration ahead_{0};     // of the wall clock, which was set back; our stamps are
  Sensor lidar_, wheels_, imu_, depth_;
  RefusalNote drives_;
  DriveSenders drive_senders_;
  bool stop_owed_ = false;   // the queue had no room for a zero
  Problem drive_stamps_;     // with the last speed
  Problem several_senders_;  // of SLAM_DRIVE
  Timestamp next_senders_look_{};
  SharedValue<Problem> drive_problem_;
  Worker worker_;
};

}  // namespace slam
