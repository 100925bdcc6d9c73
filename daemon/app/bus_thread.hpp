// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "bus/event_log.hpp"
#include "drivers/device_status.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *bus*: everything that touches LCM. Publishes, takes commands, and takes samples of sensors whose driver is
/// "lcm". Without a multicast route it keeps trying; whatever is published also goes into the record, if there is one.
class BusThread {
 public:
  /// @throws std::runtime_error when the record file cannot be opened
  BusThread(const Config& config, Exchange& exchange, const WallClock& clock);
  ~BusThread();
  Worker& worker() { return worker_; }

  bool connected() const { return connected_; }
  DeviceStatus& lidarStatus() { return lidar_; }  ///< of a lidar that comes over LCM
  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  DeviceStatus& depthStatus() { return depth_; }

 private:
  void tick();
  void connect();
  void subscribe();
  void publishPose();
  void publishRaw();
  template <typename Message>
  void publish(const char* channel, const Message& message);
  void noteSent(bool sent);
  void acknowledgeSave();
  void acknowledge(std::int32_t id, bool accepted, const std::string& message);

  /// Decodes a sensor message; what cannot be one is counted. @return the sample, its stamp in our time
  template <typename Message>
  auto receive(const lcm::ReceiveBuffer* buffer, DeviceStatus& status);
  void onScan(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void onWheels(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void onImu(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void onDepth(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void onDrive(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void onCommand(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  const Config& config_;
  Exchange& exchange_;
  const WallClock& clock_;
  std::unique_ptr<lcm::LCM> lcm_;
  std::unique_ptr<EventLogWriter> record_;
  bool record_failed_ = false;
  std::atomic<bool> connected_{false};
  Timestamp next_connect_{}, next_refresh_{}, last_sent_{};
  Duration reconnect_ = std::chrono::milliseconds(500);
  std::optional<std::int32_t> saving_;  // id of a save_map command that the mapper works on
  PoseSnapshot snapshot_;
  std::int64_t scans_published_ = 0;
  std::unique_ptr<ReceivedScan> scan_;
  std::vector<std::uint8_t> buffer_;
  DeviceStatus lidar_, wheels_, imu_, depth_;
  Worker worker_;
};

}  // namespace slam
