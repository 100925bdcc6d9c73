// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"

namespace slam {

struct NoReturnConfig {
  double step = 0.0005;           ///< [m] ranges that differ by less are one value
  int fewest = 10;                ///< beams that share a value
  int directions = 4, wide = 11;  ///< of 64 that they look in; so many cannot meet one surface at one range
  double over_others = 10.0;      ///< [1] times the beams that share a value below
  double above = 0.01;            ///< [1] of the beams have a larger range, at most: a code is at the rim
  double translation = 0.10;      ///< [m] between two places
  int places = 2;                 ///< that show the value, before it is a code
};

/// Finds the values that a lidar writes where nothing came back, though they look like ranges: the end of its reach, or
/// a few values there. Such a code lies at the rim of what the lidar measures, beams of many directions share it
/// exactly, and it is the same at every place. Of what is real they share none.
///
/// No thread, clock or I/O; after construction no allocation.
class NoReturnWatch {
 public:
  explicit NoReturnWatch(const NoReturnConfig& config = {}) : config_(config) {}

  /// @param lidar [m] where the scan was taken; nothing: that is not known
  void add(std::span<const Beam> beams, const RangeLimits& limits, const std::optional<Eigen::Vector2d>& lidar);

  /// Whether a range says that nothing came back.
  bool isCode(float range) const;
  /// [m] as they were found
  std::span<const float> codes() const { return {codes_.data(), found_}; }

 private:
  struct Candidate {
    float value = 0.0F;
    int places = 0;
  };
  struct Sample {
    float range;
    std::int8_t direction;
  };

  void countCandidates(std::span<const Sample> samples);
  void count(float value, int places);

  NoReturnConfig config_;
  std::optional<Eigen::Vector2d> last_;
  bool begun_ = false;
  std::array<Candidate, 16> candidates_{};
  std::array<float, 16> codes_{};
  std::size_t found_ = 0, next_ = 0;
  std::array<Sample, LaserScan::kCapacity> samples_;
};

}  // namespace slam
