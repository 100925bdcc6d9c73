// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "frontend/lidar_model.hpp"

namespace slam {

struct BodyWatchConfig {
  double translation = 0.10, rotation = 0.20;  ///< [m], [rad] a step: so far apart are two scans that are compared
  double same_range = 4.0;                     ///< [1] standard deviations by which two ranges may differ and be one
  double slope = 0.1;                          ///< [1] of a range, between bearings that are one surface
  double place_error = 0.02;                   ///< [m] of the motion between the two
  double few_moved = 0.4;    ///< [1] so many bearings, for each that does not change, must show the motion
  double explained = 0.6;    ///< [1] of the bearings that change must show it, too
  int enough = 3;            ///< steps until beams are left out ...
  int around = 6;            ///< bearings of half a degree on either side, of which half show a range:
  double most_around = 0.6;  ///< [1] where so many of them stay, one step is enough
  int sure = 12;             ///< ... and until the bearing is reported and stored; more are not counted
  double follow = 0.3;       ///< [1] that its range follows the newest one
  int passed = 2;            ///< steps that one takes back in which a beam goes past the place
};

/// Finds what moves with the robot. Where wheels and gyro report motion, the world must be seen from another place: a
/// range that stays as it was, though the one scan looked past where the other one has it, belongs to the robot. A wall
/// beside a robot that drives along it keeps its range, too, but no scan looks past it.
///
/// Bearings are assessed one by one. A step in which a beam goes past the place of a body takes evidence back. A step
/// in which nearly all ranges stay, or in which those that change are not where the motion has them, shows that it is
/// the motion that is wrong: of sound wheels it explains 0.8 or more of them, of a lidar upside down 0.3 or less.
///
/// No thread, clock or I/O; after construction no allocation.
class BodyWatch {
 public:
  explicit BodyWatch(const LidarModel& lidar, const BodyWatchConfig& config = {});

  /// @param beams        those within the limits are looked at
  /// @param T_odom_base  in the middle of the turn, by wheels and gyro alone
  void add(std::span<const Beam> beams, const RangeLimits& limits, const Pose2& T_odom_base);

  /// Whether a beam ends on what moves with the robot.
  bool isBody(const Beam& beam) const;

  /// What is sure.
  const BodyShape& shape() const { return shape_; }
  /// What is left out, sure or not.
  const BodyShape& leftOut() const { return left_out_; }
  /// Goes on with what another run was sure of; the first steps may refute it.
  void begin(const BodyShape& shape);

 private:
  static constexpr int bins() { return 720; }
  using Ranges = std::array<float, 720>;  // [m] the shortest in each bin; 0: none

  int binOf(double bearing) const;
  static int wrapped(int bin) { return (bin + bins()) % bins(); }
  Eigen::Vector2d pointAt(int bin, float range) const;
  /// Whether a range is the one that was seen at a bearing, or what goes on beside it.
  bool isSame(float range, const Ranges& seen, int bin) const;
  /// What a scan saw where a point is, by the sign: before it, at it, past it; nothing where it did not look.
  std::optional<int> sight(const Ranges& ranges, const Eigen::Vector2d& point) const;
  bool allStayedAround(int bin) const;
  /// @return whether most of what moves at all moved as wheels and gyro report
  bool compare(const PointTransform& T_seen_now, const PointTransform& T_now_seen);
  void update(bool moved);

  BodyWatchConfig config_;
  Pose2 T_base_lidar_;
  double side_;                     // -1 where the bearings grow clockwise
  double tolerance_;                // [m] by which two ranges may differ and be one
  std::optional<Pose2> seen_from_;  // T_odom_lidar of the scan that the next one is compared with
  Ranges seen_{}, now_{}, body_{};  // body_: [m] range that may be one
  std::array<std::int8_t, 720> steps_{};
  std::array<bool, 720> stayed_{};
  std::array<Eigen::Vector2d, 720> directions_;  // of the bins, in the lidar's frame
  int spacing_ = 2;                              // [bins] in which there is a beam on either side, at least
  BodyShape shape_, left_out_;
};

}  // namespace slam
