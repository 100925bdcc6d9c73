// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "problems/problem.hpp"

namespace slam {

/// An IMU that the kernel reads, by the attributes of its Industrial I/O: /sys/bus/iio/devices/iio:deviceN. Each value
/// is (raw + offset) * scale. A reading takes some milliseconds of its bus, so it is no matter of a real-time thread.
class IioDevice {
 public:
  struct Reading {
    Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [rad/s]
    Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< [m/s^2] specific force; zero: it has none
  };
  static constexpr const char* kRoot = "/sys/bus/iio/devices";

  /// @param wanted folder of the device, or its name below `root`, as mpu6050
  /// @param problem why there is none
  static std::optional<IioDevice> find(const std::string& wanted, Problem& problem,
                                       const std::filesystem::path& root = kRoot);

  /// The turn rates, which are read first. @return false: it cannot be read
  bool readGyro(Reading& reading) const { return gyro_.read(reading.gyro); }
  /// Accelerations; true for a device that has none.
  bool readAccel(Reading& reading) const { return !has_accel_ || accel_.read(reading.accel); }
  bool hasAccel() const { return has_accel_; }
  const std::string& name() const { return name_; }

 private:
  /// Three axes of one quantity.
  struct Axes {
    std::array<std::filesystem::path, 3> raw{};
    Eigen::Vector3d offset = Eigen::Vector3d::Zero(), scale = Eigen::Vector3d::Ones();

    /// @param quantity as in_anglvel @return whether the device has it
    bool open(const std::filesystem::path& folder, const std::string& quantity);
    bool read(Eigen::Vector3d& values) const;
  };

  std::string name_;
  Axes gyro_, accel_;
  bool has_accel_ = false;
};

}  // namespace slam
