// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/scan.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "drivers/lidar/codec/rplidar_modes.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"
#include "drivers/lidar/rplidar_scan_stream.hpp"
#include "drivers/speaker.hpp"

namespace slam {

struct RplidarConfig {
  std::string port;
  int baud = 115200;  ///< [bit/s]
  rplidar::ModeWish scan_mode = rplidar::ModeWish::kDensest;
  float range_min = 0.15F, range_max = 12.0F;  ///< [m] written into the scans, where the unit does not reach less far
};

/// Owns an RPLidar A1/A2: start-up and recovery sequence of the vendor's protocol, motor, scans out.
///
/// To be run by one thread: connect() until it succeeds, then poll() until it returns false. Waits on the descriptor.
class RplidarDriver {
 public:
  using Sink = std::function<void(const LaserScan&)>;
  using Clock = Timestamp (*)();

  RplidarDriver(const RplidarConfig& config, Clock now, Sink sink, PortOpener open = openPort);
  ~RplidarDriver() { stop(); }

  /// Opens the port, asks for info and health, starts motor and scan. Takes up to some seconds; gives up early when
  /// `cancel` becomes true. @return false with the reason in status()
  bool connect(const std::atomic<bool>& cancel);
  /// Is called by poll() before it looks after a connection that is over: that may wait and allocate.
  void setLossHandler(std::function<void()> handler) { lost_ = std::move(handler); }
  /// Waits up to `timeout` for bytes and hands finished scans to the sink.
  /// @return false when the connection is over (hung up, restarted by itself, or silent for longer than it may be)
  bool poll(Duration timeout);
  /// Scan and motor off, port closed.
  void stop();

  DeviceStatus& status() { return status_; }
  /// Of the thread that connects: what the unit said of itself, and the mode that was started last.
  const rplidar::DeviceInfo& info() const { return info_; }
  const rplidar::ScanMode& mode() const { return mode_; }

 private:
  static constexpr Duration kSilence = std::chrono::milliseconds(500);  // while streaming
  static constexpr Duration kAfterStop =
      std::chrono::milliseconds(50);  // it needs 1 ms, its last packets a little more

  void quiet();
  bool identify();
  bool noAnswer(const std::optional<rplidar::Health>& health);
  void askRate();
  void askModes();
  void askMotor();
  bool startScan();
  bool startMode(const rplidar::ScanMode& mode);
  bool endSilence();
  void findSpeaker(const std::atomic<bool>& cancel);
  void setMotor(bool on);
  bool fail(DeviceState state, const Problem& why);
  bool lose(DeviceState state, const Problem& why);
  std::vector<std::uint8_t> ask(rplidar::Request request, rplidar::AnswerType type, std::size_t size);
  std::optional<rplidar::Health> askHealth(Duration timeout);

  RplidarConfig config_;
  Clock now_;
  Sink sink_, report_scan_;
  std::function<void()> lost_ = [] {};
  PortOpener open_;
  std::int64_t rejects_before_ = 0, thinned_before_ = 0;  // of the connections before
  DeviceStatus status_;
  WrongSpeaker wrong_speaker_;
  Problem unanswered_;  // why the last attempt failed, where nobody has answered it
  std::unique_ptr<ByteStream> stream_;
  std::unique_ptr<rplidar::Dialogue> dialogue_;
  double byte_time_;  // [s]

  rplidar::DeviceInfo info_;
  rplidar::SampleRate sample_rate_;
  std::vector<rplidar::ScanMode> listed_modes_;
  std::optional<std::uint16_t> typical_mode_;
  bool motor_by_pwm_ = false, motor_by_speed_ = false;
  Problem warning_;  // although it streams

  rplidar::ScanMode mode_;
  std::size_t passed_over_ = 0;  // modes that sent nothing we understand
  std::unique_ptr<rplidar::ScanStream> scans_;
  std::vector<std::uint8_t> read_ahead_;  // behind the descriptor of the scan
  bool rests_ = false;                    // between reads
  bool catching_up_ = false;              // with bytes that waited too long
  Timestamp last_node_{}, last_turn_{}, last_arrival_{};
  std::uint32_t turns_ = 0;             // of this scan
  std::int64_t bytes_ = 0, nodes_ = 0;  // of this scan
};

}  // namespace slam
