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
  Eigen::Vector3d drive() const { return motors_on_ ? wanted_ : Eigen::Vector3d::Zero(); }
  /// What the host said with its handshakes and SET_SYSTEM_INFO.
  const std::optional<robolink::Coordinate>& coordinate() const { return coordinate_; }
  const std::optional<robolink::SystemInfo>& told() const { return told_; }

 private:
  struct Late {
    double due;  // [s] uptime
    std::vector<std::uint8_t> bytes;
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
  WheelVector angles_{}, mileage_{}, speeds_{};  // [rad] turned, [rad] counted, [rad/s]
  robolink::Imu imu_;
  robolink::SystemInfo info_;
  bool greeted_ = false;
  std::optional<robolink::Coordinate> coordinate_;
  std::optional<robolink::SystemInfo> told_;

  double uptime_ = 0.0, renewed_ = 0.0;  // [s]
  double next_check_ = 0.0;              // [s] uptime of the watchdog's next look
  int quality_ = 5;                      // of control, 5..100
  bool motors_on_ = false;
  Eigen::Vector3d wanted_ = Eigen::Vector3d::Zero();

  bool silent_ = false, garbage_ = false, stuck_ = false, imu_offline_ = false;
  int wrong_checksums_ = 0;
  double factor_ = 1.0, gyro_bias_ = 0.0;  // [1], [rad/s]
  Duration delay_{0};
  std::deque<Late> late_;
};

}  // namespace slam::sim
