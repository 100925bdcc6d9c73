// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// A stand-alone IMU at byte level, of whatever make. Pure: what it measures comes from outside, at its period.
class EmulatedImu {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Vector = std::array<double, 3>;
  static constexpr Duration kPeriod = std::chrono::milliseconds(10);
  virtual ~EmulatedImu() = default;

  /// One set of frames; to be called at the unit's rate. @param gyro [rad/s] counter-clockwise about x forward, y left,
  /// z up @param accel [m/s^2] specific force, (0, 0, +9.81) at rest @param out the bytes are appended
  virtual void sample(const Vector& gyro, const Vector& accel, Bytes& out) = 0;
  /// Bytes from the host. @param out what the unit answers is appended
  virtual void receive(std::span<const std::uint8_t> in, Bytes& out) = 0;
  /// Makes something go wrong from then on, or right again. @return false: no such kind, or not a value for it
  virtual bool inject(std::string_view kind, double value) = 0;
};

/// @param driver word of imu.driver @throws std::invalid_argument for one that nobody simulates
std::unique_ptr<EmulatedImu> makeImu(std::string_view driver);
/// Words of imu.driver that are simulated.
std::vector<std::string> imuNames();

}  // namespace slam::sim
