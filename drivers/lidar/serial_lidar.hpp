// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/scan.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "drivers/lidar/lidar_reader.hpp"
#include "drivers/lidar/lidar_unit.hpp"
#include "drivers/line_device.hpp"

namespace slam {

/// A lidar that was found on the port.
struct FoundUnit {
  std::unique_ptr<LidarUnit> unit{};  ///< nullptr: none
  int baud = 0;                       ///< [bit/s]
  LineDevice line_device = LineDevice::kUnknown;
  Problem problem{};    ///< why there is none
  bool is_open = true;  ///< the port could be opened
};
/// Looks for a lidar on the port, which is closed. May wait; gives up early when `cancel` becomes true.
using LidarFinder = std::function<FoundUnit(const PortOpener& open, const std::atomic<bool>& cancel)>;

struct SerialLidarConfig {
  std::string port;
  int baud = 115200;                              ///< [bit/s]
  LineDevice line_device = LineDevice::kRplidar;  ///< who is to be there
  LidarFinder find{};  ///< of a unit that is not known; until it has been found, and again once nobody answers
};

/// Owns a lidar on a serial port, of whatever make: port, silence, words, scans out. What differs between makes is its
/// LidarUnit's.
///
/// To be run by one thread: connect() until it succeeds, then poll() until it returns false. Waits on the descriptor.
class SerialLidar {
 public:
  using Sink = std::function<void(const LaserScan&)>;
  using Clock = LidarReader::Clock;

  /// @param unit nullptr: config.find finds it
  SerialLidar(const SerialLidarConfig& config, std::unique_ptr<LidarUnit> unit, Clock now, Sink sink,
              PortOpener open = openPort);
  SerialLidar(const SerialLidar&) = delete;
  SerialLidar& operator=(const SerialLidar&) = delete;
  ~SerialLidar() { stop(); }

  /// Opens the port and begins the scan. Takes up to some seconds; gives up early when `cancel` becomes true.
  /// @return false with the reason in status()
  bool connect(const std::atomic<bool>& cancel);
  /// Is called by poll() before it looks after a connection that is over: that may wait and allocate.
  void setLossHandler(std::function<void()> handler) { lost_ = std::move(handler); }
  /// Waits up to `timeout` for bytes and hands finished scans to the sink.
  /// @return false when the connection is over (hung up, restarted by itself, or silent for longer than it may be)
  bool poll(Duration timeout);
  /// Scan and motor off, port closed.
  void stop();

  DeviceStatus& status() { return status_; }

 private:
  bool fail(DeviceState state, const Problem& why);
  bool findUnit(const std::atomic<bool>& cancel);
  void findOtherDevice(const std::atomic<bool>& cancel, const Problem& unanswered);
  void report(const LaserScan& scan);

  SerialLidarConfig config_;
  std::unique_ptr<LidarUnit> unit_;
  Clock now_;
  Sink sink_, report_scan_;
  std::function<void()> lost_ = [] {};
  PortOpener open_;
  std::int64_t rejects_before_ = 0, thinned_before_ = 0;  // of the connections before
  DeviceStatus status_;
  WrongDevice wrong_device_;
  std::unique_ptr<ByteStream> stream_;
  std::optional<LidarReader> reader_;
  Problem warning_;  // although it streams
};

}  // namespace slam
