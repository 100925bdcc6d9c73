// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "core/samples.hpp"
#include "drivers/base/base_facts.hpp"
#include "drivers/base/counted_wheels.hpp"
#include "drivers/device_status.hpp"
#include "drivers/polled_port.hpp"
#include "drivers/speed_command.hpp"

namespace slam {

struct SerialBaseConfig {
  const BaseFacts* facts = nullptr;  ///< row of the table
  std::string port = {};
  int baud = 0;  ///< [bit/s]
  BaseProtocolConfig robot{};
  bool gyro = false;           ///< its turn rate is used
  SpeedLimits limits{};        ///< of what it commands
  bool in_background = false;  ///< the port is opened by a thread of its own
};

/// Owns a differential base at a serial port, of any make of the table: wheels, and gyro where it has one, out; speeds
/// in.
///
/// To be ticked at a fixed rate by one thread; a tick never waits, but for opening the port when there is none.
class SerialBase {
 public:
  struct Sinks {
    std::function<void(const WheelAngles&)> wheels;
    std::function<void(const ImuSample&)> imu = nullptr;
  };
  using Clock = Timestamp (*)();

  SerialBase(const SerialBaseConfig& config, Clock now, Sinks sinks, const PortOpener& open = openPort);
  ~SerialBase() { stop(); }

  void tick();
  /// Stops the robot if a stop is owed, waiting up to a quarter of a second until the base is known to have it; closes
  /// the port.
  void stop();

  /// From any one other thread, without waiting: drives the robot with a twist, vy left out, within the limits and as
  /// long as a SpeedCommand lasts. Then a stop is owed, see SpeedDuty. What was given while a wheel hung in the air, or
  /// before the base left the mode in which it drives, is not driven.
  /// @param given when; not later than now @return false when not allowed or not finite
  bool command(const Twist2& twist, Timestamp given) { return speeds_.give(twist, given); }

  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  float battery() const { return battery_; }                         ///< [V]; 0: not known yet
  std::uint64_t limitedSpeeds() const { return speeds_.limited(); }  ///< that were asked for above the limits
  /// That the configuration has another geometry than the maker.
  Problem finding() const;

 private:
  void begin(Timestamp now);
  bool receive(Timestamp now, Duration wait = Duration(0));
  void take(const BaseReading& reading);
  void emit(const BaseReading& reading);
  bool isLifted() const { return received_.at < received_.lifted_until; }
  void watch(Timestamp now);
  void send(Timestamp now);
  SideSpeeds sidesOf(const Twist2& twist) const;

  SerialBaseConfig config_;
  Clock now_;
  Sinks sinks_;
  DeviceStatus wheels_, imu_;
  DevicePort port_;
  std::unique_ptr<BaseProtocol> protocol_;
  BaseProtocol::Take take_;  // made once: no allocation later
  CountedWheels counted_;
  SpeedDuty speeds_;
  /// What was received last, and when.
  struct Received {
    Timestamp at{};            // any reading
    Timestamp lifted_until{};  // it counts as put down when no wheel has hung for a while
    Timestamp byte{};          // a byte of any sense
    Timestamp turn_rate{};
    bool isNoise() const { return byte - at > std::chrono::milliseconds(100); }
    bool obeys = true, bumped = false;
  } received_;
  std::atomic<float> battery_{0.0F};
};

}  // namespace slam
