// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "drivers/lidar/codec/rplidar_modes.hpp"
#include "drivers/lidar/lidar_unit.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"

namespace slam {

struct RplidarConfig {
  int baud = 115200;  ///< [bit/s]
  rplidar::ModeWish scan_mode = rplidar::ModeWish::kDensest;
  RangeLimits limits{};  ///< written into the scans, where the unit does not reach less far
};

/// An RPLidar: start-up and recovery sequence of the vendor's protocol, modes, motor.
class RplidarUnit : public LidarUnit {
 public:
  RplidarUnit(const RplidarConfig& config, Clock now) : config_(config), now_(now) {}

  Begun begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) override;
  Problem silence(const LidarReader& scan) override;
  void end() override;

  /// What the unit said of itself, and the mode that was started last.
  const rplidar::DeviceInfo& info() const { return info_; }
  const rplidar::ScanMode& mode() const { return mode_; }

 private:
  static constexpr Duration kAfterStop =
      std::chrono::milliseconds(50);  // it needs 1 ms, its last packets a little more

  void quiet();
  Begun identify(WrongDevice& others);
  Begun noAnswer(const std::optional<rplidar::Health>& health) const;
  void askRate();
  void askModes();
  void askMotor();
  Begun startScan();
  std::optional<LidarScanStart> startMode(const rplidar::ScanMode& mode);
  void setMotor(bool on);
  std::vector<std::uint8_t> ask(rplidar::Request request, rplidar::AnswerType type, std::size_t size);
  std::optional<rplidar::Health> askHealth(Duration timeout);

  RplidarConfig config_;
  Clock now_;
  ByteStream* port_ = nullptr;
  std::unique_ptr<rplidar::Dialogue> dialogue_;
  rplidar::DeviceInfo info_;
  rplidar::SampleRate sample_rate_;
  std::vector<rplidar::ScanMode> listed_modes_;
  std::optional<std::uint16_t> typical_mode_;
  bool motor_by_pwm_ = false, motor_by_speed_ = false;
  Problem warning_;  // although it scans
  rplidar::ScanMode mode_;
  std::size_t passed_over_ = 0;  // modes that sent nothing we understand
};

}  // namespace slam
