// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/samples.hpp"
#include "drivers/companion.hpp"
#include "drivers/device_status.hpp"
#include "drivers/polled_port.hpp"
#include "drivers/speaker.hpp"
#include "firmware_if/hfi_imu.hpp"
#include "timing/stream_clock.hpp"

namespace slam {

struct SerialImuConfig {
  std::string port = {};
  int baud = 921600;           ///< [bit/s]; D6: 9600
  bool in_background = false;  ///< the port is opened by a thread of its own
};

/// Owns a stand-alone HandsFree IMU (A9, B6, B9, D6) on a serial port. The unit talks unasked; which of the two
/// framings it speaks is found out from what comes.
///
/// Axes: the unit's x, y, z are taken to be forward, left, up of its mount, and its gyro counter-clockwise about them.
/// It gives acceleration in g with the sign of gravity; that is turned to specific force, (0, 0, +9.81) at rest. (The
/// vendor's own driver uses the gyro as it comes and multiplies acceleration by -9.8.)
///
/// To be ticked at a fixed rate by one thread; a tick never waits, but for opening the port when there is none.
class SerialImu {
 public:
  using Sink = std::function<void(const ImuSample&)>;
  using Clock = Timestamp (*)();
  enum class Framing : std::uint8_t { kUnknown, kA9, kB6 };

  SerialImu(const SerialImuConfig& config, Clock now, Sink sink);

  void tick();
  void stop() { port_.close(); }

  DeviceStatus& status() { return status_; }
  Framing framing() const { return framing_; }  ///< of the owner's thread

 private:
  void open(Timestamp now);
  void close(Timestamp now, DeviceState state, const Problem& why);
  bool receive(Timestamp now);
  void take(std::uint8_t byte, Timestamp now);
  void take(hfi::A9Decoder::Data data, Timestamp now);
  void take(const hfi::B6Frame& frame, Timestamp now);
  /// @param gravity zero: not measured
  void emit(const Eigen::Vector3d& gyro, const Eigen::Vector3d& gravity, Timestamp now);
  void recognise(Framing framing);
  std::uint32_t damage() const;
  void countRejects();
  void watch(Timestamp now);

  Clock now_;
  Sink sink_;
  DeviceStatus status_;
  PolledPort port_;
  WrongSpeaker wrong_speaker_;
  hfi::A9Decoder a9_;
  hfi::B6Decoder b6_;
  Framing framing_ = Framing::kUnknown;
  std::uint32_t a9_begin_ = 0, b6_begin_ = 0;  // frames before this opening
  std::optional<Eigen::Vector3d> b6_gravity_;  // [g] of the set under way
  Companion with_gravity_;                     // the gyro's frames of a B6
  StreamClock clock_;
  std::uint32_t damage_ = 0, not_finite_ = 0;
  bool lost_ = false;
  Eigen::Vector3d last_gyro_ = Eigen::Vector3d::Zero(), last_gravity_ = Eigen::Vector3d::Zero();
  Timestamp opened_{}, frame_{}, changed_{};
  bool bytes_came_ = false;  // since the last frame
  bool sampled_ = false;
};

}  // namespace slam
