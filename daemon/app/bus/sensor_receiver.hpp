// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "app/bus/publisher.hpp"
#include "bus/drive_senders.hpp"
#include "bus/refusal.hpp"
#include "bus/sender_clock.hpp"
#include "drivers/device_status.hpp"
#include "runtime/shared_value.hpp"

namespace slam {

/// Takes samples of sensors whose driver is "lcm", with stamps in our time. Belongs to the bus thread.
class SensorReceiver {
 public:
  SensorReceiver(const Config& config, const BusEnds& ends, const WallClock& clock, Publisher& publisher);
  /// Our own clock was set: what is known of others counts from it. @param ahead see SenderClocks::begin()
  void beginClocks(Duration ahead) { clocks_.begin(ahead); }

  DeviceStatus& lidarStatus() { return lidar_.status; }
  DeviceStatus& wheelStatus() { return wheels_.status; }
  DeviceStatus& imuStatus() { return imu_.status; }
  DeviceStatus& depthStatus() { return depth_.status; }

 private:
  using Bytes = Publisher::Bytes;
  struct Sensor {
    const char* channel;
    SenderClocks::Stream stream;
    DeviceStatus status = {};
    RefusalNote refusals = {};
  };
  /// Decodes a sensor message and records it; what cannot be one is counted. @return the sample, its stamp in our time
  template <typename Message>
  auto receive(Bytes data, Sensor& sensor);
  void onScan(Bytes data);

  const BusEnds& ends_;
  const WallClock& clock_;
  Publisher& publisher_;
  SenderClocks clocks_;
  Sensor lidar_, wheels_, imu_, depth_;
  std::unique_ptr<ReceivedScan> scan_;
  std::vector<std::uint8_t> restamped_;
};

/// Takes speeds over LCM, of whichever program is to be followed. Belongs to the bus thread.
class DriveReceiver {
 public:
  DriveReceiver(const Config& config, const BusEnds& ends, const WallClock& clock, Publisher& publisher);
  /// As that of SensorReceiver.
  void beginClocks(Duration ahead) { senders_.beginClocks(ahead); }
  /// Hands on a zero that the queue had no room for. Call it before newer speeds are received.
  void sendOwedStop();
  void report(Timestamp now);
  Problem problem() const { return problem_.get(); }  ///< from any thread

 private:
  void onDrive(Publisher::Bytes data);

  const BusEnds& ends_;
  const WallClock& clock_;
  Publisher& publisher_;
  RefusalNote refusals_;
  DriveSenders senders_;
  bool stop_owed_ = false;  // the queue had no room for a zero
  Problem stamps_;          // with the last speed
  Problem several_;         // senders
  Timestamp next_senders_look_{};
  SharedValue<Problem> problem_;
  std::vector<std::uint8_t> restamped_;
};

}  // namespace slam
