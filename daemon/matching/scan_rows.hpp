// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <span>

#include "core/scan.hpp"
#include "matching/float_row.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// Positions and normals of a scan's points, four at a time, for the passes of a match. Of more points than a scan
/// holds the first LaserScan::kCapacity.
class ScanRows {
 public:
  explicit ScanRows(std::span<const ScanPoint> points)
      : points_(std::min<std::size_t>(points.size(), LaserScan::kCapacity)) {
    for (std::size_t i = 0; i < points_; ++i) {
      const std::size_t row = i / kLanes, lane = i % kLanes;
      const auto put = [&](FloatRow& to, double value) {
        if (lane == 0) to = FloatRow{};
        to[lane] = static_cast<float>(value);
      };
      put(x_[row], points[i].position.x());
      put(y_[row], points[i].position.y());
      put(nx_[row], points[i].normal.x());
      put(ny_[row], points[i].normal.y());
    }
  }

  std::size_t points() const { return points_; }
  std::size_t size() const { return (points_ + kLanes - 1) / kLanes; }
  FloatRow x(std::size_t row) const { return x_[row]; }    ///< [m] in base
  FloatRow y(std::size_t row) const { return y_[row]; }    ///< [m]
  FloatRow nx(std::size_t row) const { return nx_[row]; }  ///< of the normal, 0 where there is none
  FloatRow ny(std::size_t row) const { return ny_[row]; }
  /// In which lanes of a row there are points.
  IntRow present(std::size_t row) const {
    const auto left = static_cast<std::int32_t>(points_ - row * kLanes);
    return IntRow{0, 1, 2, 3} < IntRow{left, left, left, left};
  }

 private:
  using Column = std::array<FloatRow, LaserScan::kCapacity / kLanes>;
  static_assert(LaserScan::kCapacity % kLanes == 0);
  Column x_, y_, nx_, ny_;  // a cache line short of four pages, so that they do not compete for one set of a cache
  std::size_t points_;
};

}  // namespace slam
