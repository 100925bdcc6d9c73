// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "core/samples.hpp"
#include "drivers/device_clock.hpp"
#include "firmware_if/can_xsens.hpp"

namespace slam {

/// Makes samples of an IMU's frames on CAN: rate of turn and acceleration of one sample time together, stamped with
/// that time in our clock.
class CanImu {
 public:
  /// @param R_base_imu takes the unit's axes to the base's
  explicit CanImu(const Eigen::Matrix3d& R_base_imu = Eigen::Matrix3d::Identity()) : R_base_imu_(R_base_imu) {}

  /// @return a sample when this frame completes one
  std::optional<ImuSample> add(const can::Frame& frame, Timestamp arrival);

  std::int64_t rejects() const { return rejects_; }  ///< damaged frames, and those that find no sample time
  /// When the readings last differed from those before: a sensor repeats itself for long only when it is broken.
  Timestamp changed() const { return changed_; }

 private:
  struct Group {
    Timestamp stamp, arrival;
    std::optional<can::xsens::Vector3> rate, acceleration;
  };
  bool begin(std::uint32_t ticks, Timestamp arrival);
  bool fill(std::optional<can::xsens::Vector3> Group::*part, const std::optional<can::xsens::Vector3>& value,
            Timestamp arrival);
  std::optional<ImuSample> finish();

  Eigen::Matrix3d R_base_imu_;
  can::xsens::TickCounter ticks_;
  DeviceClock clock_;
  std::optional<Duration> device_;     // sample time of the last good one
  Timestamp arrival_{};                // of the same
  std::optional<Duration> candidate_;  // a sample time that does not follow, less its arrival
  std::optional<Group> group_;
  std::optional<Timestamp> last_stamp_;
  can::xsens::Vector3 last_rate_{}, last_acceleration_{};
  Timestamp changed_{};
  std::int64_t rejects_ = 0;
};

}  // namespace slam
