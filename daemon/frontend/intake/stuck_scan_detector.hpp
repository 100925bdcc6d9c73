// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"

namespace slam {

struct ScanRepeatConfig {
  int fewest = 50;              ///< beams that can be compared
  double by_chance = 0.7;       ///< [1] of beams are equal by chance at most: coarse steps, walls near by
  int stuck_turns = 2;          ///< repeated in a row
  int must_change = 10;         ///< beams that the motion must have changed, and that no chance explains
  double steps = 2.0;           ///< [1] of the ranges: two of them round by one together, one more is a change
  double place_error = 0.05;    ///< [m] of the motion: stamps of lidar and wheels differ
  double heading_error = 0.01;  ///< [rad] of the motion
  double furthest = 0.5;        ///< [m] of motion: what shows none of so much shows none of more, and errors grow
  std::size_t looked_at = 360;  ///< of them at most
  double gap = 0.1;             ///< [rad] without a return: what was seen on either side may go on there
};

/// Notices a lidar that repeats a turn: to the last bit the same range at the same bearing, turn after turn.
///
/// A lidar whose ranges have coarse steps repeats most of them, too, on walls that lie along its way. So it is stuck
/// only where ranges stay that the motion must have changed: where the turn that is repeated lay, seen from where the
/// robot is now, is no longer where the beams end. No thread, clock or I/O; after construction no allocation.
class StuckScanDetector {
 public:
  /// @param side -1 where the bearings grow clockwise
  explicit StuckScanDetector(const ScanRepeatConfig& config = {}, double side = 1.0);

  /// @param codes written where nothing came back [m]: they repeat in any scan
  void add(const LaserScan& scan, std::span<const float> codes = {});

  /// Whether the newest scan shows what the one before it did, to the last bit.
  bool isRepeat() const { return is_repeat_; }
  /// Whether the newest scan is one of a stuck lidar.
  /// @param T_odom_lidar by wheels and gyro alone; nothing while they stand
  bool isStuck(const std::optional<Pose2>& T_odom_lidar);

 private:
  static constexpr std::size_t kBins = 2880;  // of an eighth of a degree
  using Ranges = std::array<float, kBins>;    // [m] 0: none

  /// What two turns have in common.
  struct Likeness {
    int compared = 0, equal = 0;
    void add(float before, float now);
  };
  struct Vertex {
    Eigen::Vector2d position;  // [m] in the lidar's frame of now
    bool first, last;          // of a line: what follows on this side was not seen
  };

  void begin(const std::optional<Pose2>& T_odom_lidar);
  bool contradicts(const Pose2& T_now_begin);
  bool hasLeft(const Eigen::Vector2d& point, std::size_t vertex, double tolerance) const;
  double step() const;

  ScanRepeatConfig config_;
  std::array<Eigen::Vector2d, kBins> directions_;  // of the bins, in the lidar's frame
  Ranges seen_{}, newest_{}, begin_{};             // the last at each bearing; of the newest turn; of the one repeated
  std::optional<Pose2> T_odom_begin_;              // lidar at the turn that is repeated, or where the wheels stood last
  std::array<Vertex, kBins> line_;                 // that turn as the robot must see it now ...
  std::size_t vertices_ = 0;                       // ... so long
  int repeats_ = 0;
  bool is_repeat_ = false, is_like_begin_ = false, stuck_ = false;
};

}  // namespace slam
