// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"
#include "estimation/base_kinematics.hpp"
#include "firmware_if/robolink.hpp"

namespace slam::sim {

/// What can go wrong with an emulated board.
struct BoardFaults {
  bool silent = false, garbage = false, stuck = false, imu_offline = false;
  int wrong_checksums = 0;
  double factor = 1.0, gyro_bias = 0.0;  ///< [1] of the wheels, [rad/s]
  Duration delay{0};

  /// @return false for an unknown kind or a value out of its range
  bool inject(std::string_view kind, double value);
};

/// A HandsFree board at byte level: handshake after start, then answers with the values it renewed last, as the open
/// firmware does.
class BoardEmulator {
 public:
  /// @param base what the robot is; its wheels are given in this order and sign
  explicit BoardEmulator(const BaseKinematics& base = {}, std::uint64_t seed = 1);

  /// New values, as the board's own loop takes them at 50 Hz. @param angles [rad] of the wheels, as in BaseKinematics
  /// @param uptime [s] since the board's start; grows
  void renew(std::span<const double> angles, const robolink::Imu& imu, double uptime);
  /// The same for a differential base. @param left, right [rad] positive driving forward
  void renew(double left, double right, const robolink::Imu& imu, double uptime) {
    renew(std::array{left, right}, imu, uptime);
  }
  /// Bytes from the host, or none. @param out answers are appended, late ones too
  void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out);
  /// The same where time passes between two renewals. @param uptime [s]
  void receive(std::span<const std::uint8_t> bytes, double uptime, std::vector<std::uint8_t>& out) {
    pass(uptime);
    receive(bytes, out);
  }

  /// Makes something go wrong from then on, or right again. @return false: no such kind, or not a value for it
  bool inject(std::string_view kind, double value);

  bool greeted() const { return greeted_; }
  /// The twist (vx [m/s], vy [m/s], omega [rad/s]) that the motors were told; zero when the firmware's watchdog has
  /// stopped them for want of commands.
  Eigen::Vector3d drive() const { return watchdog_.motorsOn() ? wanted_ : Eigen::Vector3d::Zero(); }
  /// What the host said with its handshakes and SET_SYSTEM_INFO.
  const std::optional<robolink::Coordinate>& coordinate() const { return coordinate_; }
  const std::optional<robolink::SystemInfo>& told() const { return told_; }

 private:
  struct Late {
    double due;  // [s] uptime
    std::vector<std::uint8_t> bytes;
  };
  /// What the wheels have turned, as the board counts it.
  class Wheels {
   public:
    /// @param angles [rad] true ones @param factor of what they turn @param uptime [s]
    void renew(std::span<const double> angles, double factor, double uptime);
    void clear() { mileage_ = {}; }
    const WheelVector& mileage() const { return mileage_; }  ///< [rad]
    const WheelVector& speeds() const { return speeds_; }    ///< [rad/s]

   private:
    WheelVector angles_{}, mileage_{}, speeds_{};
    double renewed_ = 0.0;  // [s]
  };
  /// The firmware's watchdog: the motors are on as long as commands come.
  class Watchdog {
   public:
    void pass(double uptime);
    void command();
    void restart();
    bool motorsOn() const { return motors_on_; }

   private:
    double next_check_ = 0.0;  // [s] uptime
    int quality_ = 5;          // of control, 5..100
    bool motors_on_ = false;
  };

  void pass(double uptime);
  void handle(const robolink::Frame& frame, std::vector<std::uint8_t>& out);
  void answer(robolink::Command command, std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& out);
  robolink::MotorVector servos(const WheelVector& wheels) const;
  robolink::ChassisParameters chassis() const;
  void restart();

  BaseKinematics base_;
  std::mt19937_64 random_;
  robolink::Decoder decoder_{robolink::kSlave, robolink::kMaster};
  Wheels wheels_;
  robolink::Imu imu_;
  robolink::SystemInfo info_;
  bool greeted_ = false;
  std::optional<robolink::Coordinate> coordinate_;
  std::optional<robolink::SystemInfo> told_;

  double uptime_ = 0.0;  // [s]
  Watchdog watchdog_;
  Eigen::Vector3d wanted_ = Eigen::Vector3d::Zero();
  BoardFaults faults_;
  std::deque<Late> late_;
};

}  // namespace slam::sim
