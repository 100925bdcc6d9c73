// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <deque>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"
#include "firmware_if/can_odrive.hpp"
#include "firmware_if/can_vesc.hpp"
#include "firmware_if/can_xsens.hpp"

namespace slam::sim {

/// What the devices on the bus measure at one moment.
struct CanReadings {
  std::array<double, 2> angles{};  ///< [rad] left, right; positive driving forward
  can::xsens::Vector3 gyro{};      ///< [rad/s]
  can::xsens::Vector3 accel{};     ///< [m/s^2]
  can::xsens::Quaternion attitude{1, 0, 0, 0};
};

/// What can go wrong with the devices on the bus.
struct CanFaults {
  bool silent = false, garbage = false, stuck = false, deaf = false;
  double factor = 1.0;  ///< of the positions
  int slow = 1;         ///< factor of the periods
  Duration delay{0};
  double watchdog = 0.0;  ///< [s] 0: off
  can::odrive::Dialect dialect = can::odrive::Dialect::k05;
  int time_every = 1, acceleration_every = 1;  ///< sent with every so many'th turn rate, 0 never
  bool quaternion = true;

  /// @return false for an unknown kind or a value out of its range
  bool inject(std::string_view kind, double value);
};

/// The drives of two wheels and an IMU on one CAN bus, frame by frame at the rates of firmware_if/README.md. Knows no
/// clock: time and truth come from outside.
class CanEmulator {
 public:
  /// At which a drive of firmware 0.6 tells whether its watchdog is on.
  static constexpr std::uint16_t kWatchdogEndpoint = 201;
  static constexpr std::array<int, 2> kNodes{can::odrive::kLeftNode, can::odrive::kRightNode};

  static constexpr int kPolePairs = 7;  ///< of the VESCs' motors

  /// @param nodes left, right @param protocol of the drives
  explicit CanEmulator(std::uint64_t seed = 1, const std::array<int, 2>& nodes = kNodes,
                       can::Protocol protocol = can::Protocol::kOdrive)
      : random_(seed), protocol_(protocol) {
    for (std::size_t side = 0; side < 2; ++side) drives_[side].node = nodes[side];
  }

  /// Makes the frames that are due up to `now`; to be called every few milliseconds, time going on.
  /// @param out frames in the order of the bus are appended; error frames are for the host's controller
  void step(Timestamp now, const CanReadings& readings, std::vector<can::Frame>& out);

  /// A frame from the host. What a drive answers comes with the next step.
  void receive(const can::Frame& frame);
  /// Speeds asked for last [turns/s], as sent to each drive.
  std::array<float, 2> asked() const { return {drives_[0].asked, drives_[1].asked}; }
  int commands() const { return commands_; }  ///< speeds received
  bool armed() const { return drives_[0].armed() && drives_[1].armed(); }
  /// Speeds at which the motors turn the wheels [turns/s]: those asked for last, for ever, while the drive is armed.
  std::array<float, 2> drive() const;

  /// Makes something go wrong, or right again. @return false: no such kind, or not a value for it
  bool inject(std::string_view kind, double value);

 private:
  struct Drive {
    int node = 0;
    double angle = 0.0;                     // [rad] of its wheel, at turned_
    float asked = 0.0F;                     // [turns/s]
    double position = 0.0, velocity = 0.0;  // [turns, turns/s]
    bool fed = true;                        // by a frame from the host, since the last step
    bool asked_version = false, asked_watchdog = false;
    Timestamp fed_at{};
    can::odrive::Heartbeat heartbeat{.state = static_cast<std::uint8_t>(can::odrive::AxisState::kClosedLoop)};

    bool armed() const { return heartbeat.state == static_cast<std::uint8_t>(can::odrive::AxisState::kClosedLoop); }
  };
  void turn(Timestamp now, const CanReadings& readings);
  void watch(Timestamp now);
  void send(Timestamp now, can::Frame frame);
  void spoil(can::Frame& frame);
  void sendImu(Timestamp now);
  void sendEstimates(Timestamp now);
  void sendStatus(Timestamp now);
  void sendAnswers(Timestamp now);

  std::mt19937_64 random_;
  can::Protocol protocol_;
  std::array<Drive, 2> drives_;
  CanReadings imu_;
  std::optional<Timestamp> started_, turned_;
  Timestamp next_estimates_{}, next_heartbeat_{}, next_imu_{};
  struct Delayed {
    Timestamp due;
    can::Frame frame;
  };
  std::deque<Delayed> line_;
  int commands_ = 0;
  CanFaults faults_;
  bool bus_off_ = false;
  Duration estimates_ = std::chrono::milliseconds(10);
  int imu_samples_ = 0;
};

}  // namespace slam::sim
