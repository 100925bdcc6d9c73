// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "core/timestamp.hpp"

namespace slam {

struct SweepWatchConfig {
  double turn = 0.4, most_turn = 1.0;  ///< [rad] between two scans that are compared
  double turn_rate = 0.5;              ///< [rad/s] slower turns say little
  double longest = 1.0;                ///< [s] between them
  double same_range = 0.10;            ///< [m] of the same thing in both
  int fewest = 60;                     ///< beams that can be compared
  double clearly_better = 0.05;        ///< [1] of the beams, that meet the other scan with beam times
  int enough = 3;                      ///< comparisons more for it than against
  int most = 6;                        ///< comparisons more that are remembered
};

/// Where a scan's beams carry no times, finds out whether they were measured one after the other, as a head turns, or
/// all at once. A robot that turns sees with each beam what it saw some beams further on before. Where that is hangs on
/// when the beams were measured; only with their right times does one scan meet the other everywhere.
///
/// No thread, clock or I/O; after construction no allocation.
class SweepWatch {
 public:
  explicit SweepWatch(bool upside_down = false, const SweepWatchConfig& config = {})
      : config_(config), side_(upside_down ? -1.0 : 1.0) {}

  /// When a scan's beams were measured.
  enum class Order : std::int8_t { kReverse = -1, kAtOnce = 0, kForward = 1 };

  /// A scan without beam times, and where wheels and gyro have the lidar when it begins and when the next one is due.
  struct Moved {
    Pose2 begin, end;
  };
  void add(std::span<const Beam> beams, const RangeLimits& limits, Timestamp first, double interval,
           const Moved& moved);

  Order order() const { return order_; }
  /// [1] of the time to the next scan, in which the beams of a scan are measured
  static double sweepOf(std::span<const Beam> beams);

 private:
  static constexpr int bins() { return 360; }
  struct Seen {
    Timestamp first;
    Moved moved;
    double sweep = 0.0;
    std::array<float, 360> ranges{}, shares{};  // [m] 0: none; [1] of the scan's beams before it
  };

  static std::size_t binOf(double bearing);
  std::optional<double> meets(std::span<const Beam> beams, const RangeLimits& limits, const Moved& moved, double sweep,
                              Order order) const;
  void keep(std::span<const Beam> beams, const RangeLimits& limits, Timestamp first, double sweep, const Moved& moved);
  void count(double at_once, double forward, double reverse);

  SweepWatchConfig config_;
  double side_;
  std::optional<Seen> seen_;
  int forward_ = 0, reverse_ = 0;  // comparisons more for them than against
  Order order_ = Order::kAtOnce;
};

}  // namespace slam
