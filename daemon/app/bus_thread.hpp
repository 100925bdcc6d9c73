// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "app/recorder.hpp"
#include "bus/lcm_link.hpp"
#include "drivers/device_status.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *bus*: everything that touches LCM. Publishes, takes commands, and takes samples of sensors whose driver is
/// "lcm". Without a network it keeps trying; whatever is published also goes into the record, if there is one.
class BusThread {
 public:
  BusThread(const Config& config, Exchange& exchange, const WallClock& clock);
  ~BusThread();
  Worker& worker() { return worker_; }

  Recorder* recorder() const { return recorder_.get(); }  ///< nullptr where nothing is recorded
  LinkState linkState() const { return link_state_; }
  const UdpmUrl& url() const { return link_.url(); }
  DeviceStatus& lidarStatus() { return lidar_; }  ///< of a lidar that comes over LCM
  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  DeviceStatus& depthStatus() { return depth_; }

 private:
  using Bytes = std::span<const std::uint8_t>;

  void tick();
  void subscribe();
  void reportLink(Timestamp now);
  void publishPose();
  void publishRaw();
  template <typename Message>
  void publish(const char* channel, const Message& message);
  void acknowledgeSave();
  void acknowledge(std::int32_t id, bool accepted, const std::string& message);

  /// Decodes a sensor message; what cannot be one is counted. @return the sample, its stamp in our time
  template <typename Message>
  auto receive(Bytes data, DeviceStatus& status);
  void onScan(Bytes data);
  void onWheels(Bytes data);
  void onImu(Bytes data);
  void onDepth(Bytes data);
  void onDrive(Bytes data);
  void onCommand(Bytes data);

  const Config& config_;
  Exchange& exchange_;
  const WallClock& clock_;
  LcmLink link_;
  std::unique_ptr<Recorder> recorder_;
  std::atomic<LinkState> link_state_{LinkState::kOpening};
  bool too_large_logged_ = false;
  Timestamp next_refresh_{};
  std::optional<std::int32_t> saving_;  // id of a save_map command that the mapper works on
  PoseSnapshot snapshot_;
  std::int64_t scans_published_ = 0;
  std::unique_ptr<ReceivedScan> scan_;
  std::vector<std::uint8_t> buffer_;
  DeviceStatus lidar_, wheels_, imu_, depth_;
  Worker worker_;
};

}  // namespace slam
