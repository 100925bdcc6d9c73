// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/samples.hpp"
#include "drivers/base/wheel_angles.hpp"
#include "drivers/can/can_axis.hpp"
#include "drivers/can/can_imu.hpp"
#include "drivers/can/can_link.hpp"
#include "drivers/can/can_wheels.hpp"
#include "drivers/can/follow_watch.hpp"
#include "drivers/can/vesc_drive.hpp"
#include "drivers/device_status.hpp"
#include "drivers/speed_command.hpp"

namespace slam {

struct CanBaseConfig {
  std::string interface = "can0";
  bool wheels = true;  ///< taken from this bus
  bool imu = true;     ///< the same; both can be told apart, e.g. wheels here and the IMU on a serial line
  can::Protocol protocol = can::Protocol::kOdrive;  ///< of the wheels' drives
  std::array<int, 2> nodes{can::odrive::kLeftNode,
                           can::odrive::kRightNode};  ///< left, right; 0..63, ids of VESCs 0..254
  int pole_pairs = 0;                                 ///< of a VESC's motor
  CanWheelsConfig wheel{};
  Eigen::Matrix3d R_base_imu = Eigen::Matrix3d::Identity();  ///< takes the IMU's axes to the base's
  bool commands = false;  ///< command the drives, see command(); nothing is ever sent otherwise
  double wheel_radius = 0.0325, half_track = 0.10075;  ///< [m] of the base that is commanded
  SpeedLimits limits{};                                ///< of what it commands
};

/// Owns a CAN bus with the drives of two wheels (ODrive CANSimple or VESC) and an IMU (Xsens frames).
///
/// To be ticked at a fixed rate, faster than the frames come, by one thread; a tick never waits, but for opening the
/// interface when there is none. It does not set the bit rate, nor bring the interface up: that is the system's.
class CanBase {
 public:
  struct Sinks {
    std::function<void(const WheelAngles&)> wheels;
    std::function<void(const ImuSample&)> imu;
  };
  using Clock = Timestamp (*)();

  /// @param now CLOCK_MONOTONIC
  CanBase(const CanBaseConfig& config, Clock now, Sinks sinks);
  /// @param port instead of SocketCAN
  CanBase(const CanBaseConfig& config, Clock now, Sinks sinks, std::unique_ptr<CanPort> port);

  void tick();
  /// Stops the wheels where it commands them, waiting for room in a full queue up to a tenth of a second; closes the
  /// bus.
  void stop();

  /// The twist that the base shall have, within the limits and as long as a SpeedCommand lasts; vy is left out. From
  /// any one thread, no lock. As long as the bus is usable the drives get a speed each at 50 Hz: this one, else zero.
  /// So the next frame heals whatever was lost, and whatever speed a drive holds; and its own watchdog trips only when
  /// this ends. Zero is also what both get while one of them does not obey, or is not known to; then a new twist is
  /// needed.
  /// @param given when; not later than now @return false when not allowed or not finite
  bool command(const Twist2& twist, Timestamp given);
  bool command(const Twist2& twist) { return command(twist, now_()); }

  DeviceStatus& wheelStatus() { return wheel_status_; }
  DeviceStatus& imuStatus() { return imu_.status(); }
  const CanLinkCounters& linkCounters() const { return link_.counters(); }  ///< of the ticking thread
  std::uint64_t limitedSpeeds() const { return command_.limited(); }        ///< that were asked for above the limits

 private:
  void handle(const StampedCanFrame& received);
  void handleHeartbeat(std::size_t side, const StampedCanFrame& received);
  void handleEstimates(std::size_t side, const StampedCanFrame& received);
  void handleVesc(const StampedCanFrame& received);
  void addEstimates(std::size_t side, Timestamp stamp, const can::odrive::EncoderEstimates& estimates);
  void handleImu(const StampedCanFrame& received);
  void emit(const CanWheels::Pair& pair);
  void storeRejects() { wheel_status_.rejects.store(wheels_.rejects(), std::memory_order_relaxed); }
  void takeCommand(Timestamp now);
  void sendCommand(Timestamp now);
  void askVersions(Timestamp now);
  /// @return whether the interface has taken both
  bool sendSpeeds(Timestamp now, const Twist2& twist);
  /// Stops both wheels while one does not obey.
  void watchObedience(Timestamp now);
  bool obeys(std::size_t side, Timestamp now) const;
  /// Why a wheel does not obey; none: it does, or nothing is known yet.
  Problem hindrance(std::size_t side) const;
  void watchWheels(Timestamp now);
  void watchImu(Timestamp now);
  /// What the link itself has to say. @return false: the bus can be used
  bool watchLink(DeviceStatus& status);
  /// How long a wheel may be silent, by the period at which its drive sends.
  Duration patience(std::size_t side) const;
  Problem warning(Timestamp now) const;
  void setStale(DeviceStatus& status, const Problem& why) const;
  /// @param report of its drive
  Problem ofWheel(const ProblemKind& kind, std::size_t side, std::string_view report = {}) const;
  Problem noHeartbeat(std::size_t side) const;
  Problem notArmed(std::size_t side) const;
  Problem slowEstimates(std::size_t side) const;
  Problem axisError(std::size_t side) const;

  CanBaseConfig config_;
  Clock now_;
  Sinks sinks_;
  DeviceStatus wheel_status_;
  CanLink link_;
  std::array<CanAxis, 2> axes_;
  std::array<VescDrive, 2> vescs_;
  CanWheels wheels_;
  CanImuUnit imu_;
  LinkSilence silence_;
  Timestamp last_pair_{};  // when it was handed on
  SpeedCommand command_;
  std::optional<Twist2> twist_;  // of this tick; none: both wheels stand
  FollowWatch follow_;
  Timestamp next_command_{};
};

}  // namespace slam
