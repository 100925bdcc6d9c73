// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "core/samples.hpp"
#include "drivers/can/can_link.hpp"
#include "drivers/companion.hpp"
#include "drivers/device_status.hpp"
#include "firmware_if/can_xsens.hpp"
#include "timing/device_clock.hpp"

namespace slam {

/// Makes samples of an IMU's frames on CAN. Each turn rate makes one: it is what the pose needs. Acceleration and
/// sample time are joined to it where the unit sends them with each; where it does not, or more seldom, the turn rate
/// is used without acceleration, and with the stamp of its arrival. A part that is only lost once is waited for: its
/// sample is left out, so that parts of different samples are never joined.
class CanImu {
 public:
  /// @param R_base_imu takes the unit's axes to the base's
  explicit CanImu(const Eigen::Matrix3d& R_base_imu = Eigen::Matrix3d::Identity()) : R_base_imu_(R_base_imu) {}

  /// @return a sample when this frame completes one
  std::optional<ImuSample> add(const can::Frame& frame, Timestamp arrival);

  std::int64_t rejects() const { return rejects_; }  ///< damaged frames, and those that find no sample time
  /// When the readings last differed from those before: a sensor repeats itself for long only when it is broken.
  Timestamp changed() const { return changed_; }
  bool usesTime() const { return with_time_.expected(); }                  ///< that the unit sends, for its stamps
  bool usesAcceleration() const { return with_acceleration_.expected(); }  ///< in each of its samples

 private:
  struct Group {
    Timestamp stamp, arrival;
    std::optional<can::xsens::Vector3> rate, acceleration;
  };
  /// Stamps by the unit's sample times. One damaged sample time must not bend the clock: what does not follow has to
  /// come twice.
  class SampleTimes {
   public:
    /// @return std::nullopt: it does not follow those before
    std::optional<Timestamp> stamp(std::uint32_t ticks, Timestamp arrival);

   private:
    can::xsens::TickCounter ticks_;
    DeviceClock clock_;
    std::optional<Duration> device_;     // sample time of the last good one
    Timestamp arrival_{};                // of the same
    std::optional<Duration> candidate_;  // a sample time that does not follow, less its arrival
  };
  bool addTime(std::uint32_t ticks, Timestamp arrival);
  std::optional<ImuSample> addRate(const std::optional<can::xsens::Vector3>& rate, Timestamp arrival);
  std::optional<ImuSample> addAcceleration(const std::optional<can::xsens::Vector3>& acceleration, Timestamp arrival);
  std::optional<ImuSample> reject();
  std::optional<ImuSample> make(const Group& group);

  Eigen::Matrix3d R_base_imu_;
  SampleTimes times_;
  std::optional<Group> group_;
  Companion with_time_, with_acceleration_;  // of the turn rates
  bool time_came_ = false;                   // a sample time did since the last turn rate, good or damaged
  std::optional<bool> accelerated_;          // the last turn rate that found its sample time, by its acceleration
  std::optional<Timestamp> last_stamp_;
  can::xsens::Vector3 last_rate_{}, last_acceleration_{};
  Timestamp changed_{};
  std::int64_t rejects_ = 0;
};

/// A unit on CAN with its state: which of its frames come, and whether samples follow from them.
class CanImuUnit {
 public:
  explicit CanImuUnit(const Eigen::Matrix3d& R_base_imu) : imu_(R_base_imu) {}

  DeviceStatus& status() { return status_; }
  /// @return a sample when this frame completes one, and the unit is not frozen
  std::optional<ImuSample> add(const StampedCanFrame& received, Timestamp now);
  struct Finding {
    DeviceState state;
    Problem problem;
  };
  /// Where the link is usable.
  Finding look(const LinkSilence& silence, Timestamp now) const;

 private:
  CanImu imu_;
  DeviceStatus status_;
  Timestamp last_sample_{};                                    // when it was handed on
  Timestamp last_time_{}, last_rate_{}, last_acceleration_{};  // frames
};

}  // namespace slam
