// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "app/channels.hpp"
#include "config/config.hpp"
#include "drivers/base/serial_base.hpp"
#include "drivers/board/handsfree_board.hpp"
#include "drivers/can/can_base.hpp"
#include "drivers/imu/iio_imu.hpp"
#include "drivers/imu/serial_imu.hpp"
#include "estimation/wheel_odometry.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *base*: wheels and IMU of our own devices into the queues, whichever of board, other base, CAN bus and serial
/// IMU they come from; speeds to the wheels where that is allowed.
class BaseThread {
 public:
  BaseThread(const Config& config, const BaseEnds& ends);
  ~BaseThread();
  Worker& worker() { return worker_; }

  DeviceStatus* wheelStatus();  ///< nullptr: the wheels are not read here
  DeviceStatus* imuStatus();
  double imuRate() const;  ///< [Hz] expected; 0: not known
  double wheelRate() const;
  bool usesCan() const { return can_.has_value(); }
  float battery() const {
    return board_ ? board_->battery() : serial_ ? serial_->battery() : 0.0F;
  }  ///< [V]; 0: not known
  /// Speeds that were asked for above base.max_speed or base.max_turn_rate.
  std::uint64_t limitedSpeeds() const {
    if (serial_) return serial_->limitedSpeeds();
    return board_ ? board_->limitedSpeeds() : can_ ? can_->limitedSpeeds() : 0;
  }
  /// What board and configuration disagree on.
  Problem finding() const { return board_ ? board_->finding() : serial_ ? serial_->finding() : Problem(); }
  /// Ends the thread, stops the wheels if they may turn, and closes all ports.
  void stop();

  /// @return whether the configuration asks for any such device
  static bool isWanted(const Config& config);

 private:
  void tick();
  void addWheels(const WheelAngles& angles);
  void addImu(const ImuSample& sample);
  void drive();

  const Config& config_;
  const BaseEnds ends_;
  BaseKinematics kinematics_;
  WheelOdometry odometry_;
  Eigen::Matrix3d R_base_imu_;
  std::optional<HandsfreeBoard> board_;
  std::optional<SerialBase> serial_;
  std::optional<CanBase> can_;
  std::optional<SerialImu> imu_;
  std::optional<IioImu> iio_;
  Worker worker_;
};

}  // namespace slam
