// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "core/timestamp.hpp"

namespace slam {

struct CabinWatchConfig {
  double largest = 5.0;  ///< [m^2] of a lift's cabin: that for 2500 kg, or 33 persons (EN 81-20, available car area)
  double shut = 0.6;     ///< [1] of the area in view is left when its door shuts, at most
  Duration shut_for = std::chrono::seconds(3);  ///< at least: who stops before the robot for a moment shuts nothing
  double moved = 0.1;                           ///< [m] the view is another one
  double turned = 0.1;                          ///< [rad] so is it, unless the lidar looks all around
  double widest_gap = 0.1;                      ///< [rad] between two beams that come back: no one sees what is in it
  double seen = 0.75;                           ///< [1] of the field of view: else it is not known what is around
  double all_around = 6.0;                      ///< [rad]
};

/// Notices that the robot may have taken a lift. All that it sees of a floor then goes out of view while it stands:
/// what is left is no larger than a cabin. Some time later it sees more again. How large an area a scan sees in a cabin
/// is the same wherever in it the robot is, and however it has turned. A door that shuts a small room looks the same.
class CabinWatch {
 public:
  explicit CabinWatch(const CabinWatchConfig& config = {}) : config_(config) {}

  /// @param beams    of a turn in their order @param limits of ranges that count
  /// @param T_odom_base how the robot moves by wheels and gyro
  void add(std::span<const Beam> beams, const RangeLimits& limits, const Pose2& T_odom_base, Timestamp now);
  /// Whether the newest scan is the first that sees out of what may have been a cabin.
  bool opened() const { return opened_; }

  struct View {
    double area = 0.0;   ///< [m^2] between the lidar and what it meets, as if it looked all around
    double field = 0.0;  ///< [rad] that the beams span
    double seen = 0.0;   ///< [rad] of it in which they come back
  };
  View viewOf(std::span<const Beam> beams, const RangeLimits& limits) const;

 private:
  CabinWatchConfig config_;
  Pose2 at_;                             // in odom: the views since are from one place
  double widest_ = 0.0;                  // [m^2] of these
  std::optional<Timestamp> shut_since_;  // less than that is in view
  double cabin_ = 0.0;                   // [m^2] in view since it shut
  bool shut_ = false, opened_ = false;   // for long enough; by the newest scan
};

}  // namespace slam
