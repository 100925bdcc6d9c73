// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/scan.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "drivers/rplidar_codec.hpp"
#include "drivers/sample_clock.hpp"
#include "drivers/scan_assembler.hpp"

namespace slam {

struct RplidarConfig {
  std::string port;
  int baud = 115200;                           ///< [bit/s]
  std::string scan_mode = "auto";              ///< "auto", "express", "standard"
  float range_min = 0.15F, range_max = 12.0F;  ///< [m] written into the scans
};

/// Owns an RPLidar A1/A2: start-up and recovery sequence of the vendor's protocol, motor, scans out.
///
/// To be run by one thread: connect() until it succeeds, then poll() until it returns false. Waits on the descriptor.
class RplidarDriver {
 public:
  using Sink = std::function<void(const LaserScan&)>;
  using Clock = Timestamp (*)();

  RplidarDriver(const RplidarConfig& config, Clock now, Sink sink);
  ~RplidarDriver() { stop(); }

  /// Opens the port, asks for info and health, starts motor and scan. Takes up to some seconds; gives up early when
  /// `cancel` becomes true. @return false with the reason in status()
  bool connect(const std::atomic<bool>& cancel);
  /// Waits up to `timeout` for bytes and hands finished scans to the sink.
  /// @return false when the connection is over (hung up, or silent for longer than a turn can take)
  bool poll(Duration timeout);
  /// Scan and motor off, port closed.
  void stop();

  DeviceStatus& status() { return status_; }

 private:
  bool openAndQuiet();
  bool identify();
  bool startScan();
  bool startScan(bool express);
  bool send(std::span<const std::uint8_t> bytes) { return stream_ && stream_->write(bytes); }
  void setMotor(bool on);
  void drain(Duration silence, Duration limit);
  bool pause(Duration time);
  std::vector<std::uint8_t> ask(rplidar::Request request, rplidar::AnswerType type, std::size_t size, Duration timeout);
  bool awaitDescriptor(rplidar::AnswerType type, std::size_t size, Duration timeout);
  bool cancelled() const { return cancel_ != nullptr && *cancel_; }
  bool fail(DeviceState state, const char* reason);

  RplidarConfig config_;
  Clock now_;
  Sink sink_;
  DeviceStatus status_;
  std::unique_ptr<ByteStream> stream_;
  std::vector<std::uint8_t> input_;  // read ahead of a descriptor or answer
  rplidar::DeviceInfo info_;
  rplidar::SampleRate sample_rate_;
  bool motor_by_pwm_ = false;
  const std::atomic<bool>* cancel_ = nullptr;  // of the present connect()
  double byte_time_;                           // [s]
  std::unique_ptr<rplidar::StreamDecoder> decoder_;
  rplidar::ScanAssembler assembler_;
  std::vector<rplidar::TimedNode> nodes_;
  Timestamp last_node_{};
  SampleClock sample_clock_{1.0};
  bool hung_up_ = false;
};

}  // namespace slam
