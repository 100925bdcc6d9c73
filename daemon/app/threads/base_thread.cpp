// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/base_thread.hpp"

#include <algorithm>
#include <ctime>

#include "app/device_configs.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

// [Hz] at which values are new, by firmware_if/README.md: encoder estimates and IMU frames on CAN, the board's mileage
// and IMU.
constexpr double kCanRate = 100.0, kBoardWheelRate = 20.0, kBoardImuRate = 50.0;

/// What local time is ahead of our clock.
Duration localTimeOffset() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  return wallClockOffset() + std::chrono::seconds(local.tm_gmtoff);
}

}  // namespace

bool BaseThread::isWanted(const Config& config) {
  const auto ours = [](auto driver) { return driver != decltype(driver)::kLcm && driver != decltype(driver)::kNone; };
  return ours(config.base_device.driver) || ours(config.imu_device.driver);
}

BaseThread::BaseThread(const Config& config, const BaseEnds& ends)
    : config_(config),
      ends_(ends),
      kinematics_(kinematicsOf(config.base_device)),
      odometry_(kinematics_),
      R_base_imu_(imuRotation(config.imu_device)),
      worker_(baseWorker(config), [this] { tick(); }) {
  const BaseDeviceConfig& base = config.base_device;
  const ImuDeviceConfig& imu = config.imu_device;
  const auto wheels_in = [this](const WheelAngles& angles) { addWheels(angles); };
  const auto imu_in = [this](const ImuSample& sample) { addImu(sample); };
  if (base.driver == BaseDriver::kHandsfree) {
    HandsfreeBoard::Sinks sinks{.wheels = wheels_in};
    if (imu.driver == ImuDriver::kHandsfree) sinks.imu = imu_in;
    board_.emplace(handsfreeConfig(config), &monotonicNow, sinks);
    board_->setLocalTimeOffset(localTimeOffset());
  }
  if (baseFacts(config) != nullptr) {
    SerialBase::Sinks sinks{.wheels = wheels_in};
    if (imu.driver == ImuDriver::kBase) sinks.imu = imu_in;
    serial_.emplace(serialBaseConfig(config), &monotonicNow, sinks);
  }
  if (base.driver == BaseDriver::kCan || imu.driver == ImuDriver::kCan) {
    can_.emplace(canBaseConfig(config), &monotonicNow, CanBase::Sinks{wheels_in, imu_in});
  }
  if (imuFacts(config) != nullptr) {
    imu_.emplace(serialImuConfig(config), &monotonicNow, imu_in);
  }
  if (imu.driver == ImuDriver::kIio) iio_.emplace(iioImuConfig(config), &monotonicNow, imu_in);
}

BaseThread::~BaseThread() { stop(); }

void BaseThread::stop() {
  worker_.stop();
  if (board_) board_->stop();
  if (serial_) serial_->stop();
  if (can_) can_->stop();
  if (imu_) imu_->stop();
  if (iio_) iio_->stop();
}

void BaseThread::tick() {
  drive();
  if (board_) board_->tick();
  if (serial_) serial_->tick();
  if (can_) can_->tick();
  if (can_) ends_.can_counters.store(can_->linkCounters());
  if (imu_) imu_->tick();
  if (iio_) iio_->tick();
}

void BaseThread::drive() {
  ends_.drives.drain([this](const DriveCommand& command) {
    const Twist2& twist = command.twist;
    if (board_) board_->command(twist.vx, twist.vy, twist.omega, command.given);
    if (serial_) serial_->command(twist, command.given);
    if (can_) can_->command(twist, command.given);
  });
}

void BaseThread::addWheels(const WheelAngles& angles) {
  if (angles.restarted) odometry_.restart();
  const Pose2& pose = odometry_.add(angles.used());
  if (board_) board_->setCoordinate(pose.x, pose.y, pose.theta);
  const WheelSample sample{
      .stamp = angles.stamp, .T_wheels_base = pose, .restarted = angles.restarted, .lifted = angles.lifted};
  ends_.wheels.push({sample, angles.angles, angles.count});
}

void BaseThread::addImu(const ImuSample& sample) { ends_.imu.push(inBase(R_base_imu_, sample)); }

DeviceStatus* BaseThread::wheelStatus() {
  if (board_) return &board_->wheelStatus();
  if (serial_) return &serial_->wheelStatus();
  return config_.base_device.driver == BaseDriver::kCan ? &can_->wheelStatus() : nullptr;
}

DeviceStatus* BaseThread::imuStatus() {
  const ImuDriver driver = config_.imu_device.driver;
  if (driver == ImuDriver::kHandsfree) return &board_->imuStatus();
  if (driver == ImuDriver::kBase) return &serial_->imuStatus();
  if (driver == ImuDriver::kCan) return &can_->imuStatus();
  if (iio_) return &iio_->status();
  return imu_ ? &imu_->status() : nullptr;
}

double BaseThread::wheelRate() const {
  if (serial_) return baseFacts(config_)->rate;
  return config_.base_device.driver == BaseDriver::kCan ? kCanRate
                                                        : std::min(config_.base_device.mileage_rate, kBoardWheelRate);
}

double BaseThread::imuRate() const {
  if (config_.imu_device.driver == ImuDriver::kCan) return kCanRate;
  if (config_.imu_device.driver == ImuDriver::kBase) return baseFacts(config_)->rate;
  if (const ImuFacts* facts = imuFacts(config_)) return facts->rate;
  return config_.imu_device.driver == ImuDriver::kHandsfree ? std::min(config_.base_device.imu_rate, kBoardImuRate)
                                                            : 0.0;
}

}  // namespace slam
