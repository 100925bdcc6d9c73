// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <numbers>
#include <span>

#include "matching/scan_points.hpp"

namespace slam {

struct RangeImageConfig {
  double max_gap = 0.06;         ///< [rad] between two beams: what lies in a wider one was not seen
  double margin = 0.20;          ///< [m] that a range and a place may differ by and be the same
  double bearing_error = 0.010;  ///< [rad] of the pose that a place is seen from ...
  double place_error = 0.05;     ///< [m] ... and of the place
  double grazing = 0.3;          ///< cosine of the angle between beam and normal
};

/// @return [rad] atan2(y, x) off by less than kRoughBearingError, at a third of its cost; NaN at the origin
float roughBearing(float x, float y);
inline constexpr double kRoughBearingError = 3e-5;  ///< [rad] of its polynomial and rounding

/// How far a scan saw in each direction. A wall that it saw through is not there, or the scan was taken elsewhere:
/// points that match show nothing of that. After the range images of Kim and Kim (Removert, IROS 2020).
class RangeImage {
 public:
  /// What a scan shows of a place.
  enum class Visibility : std::uint8_t {
    kUnknown,     ///< no beam went there, or it passed along the wall
    kOccluded,    ///< something stands before it
    kConsistent,  ///< something is there
    kViolated,    ///< all beams near it went on
  };

  explicit RangeImage(const RangeImageConfig& config = {}) : config_(config) {}

  /// @param points  in acquisition order, in base
  /// @param lidar   [m] position of the lidar in base
  void set(std::span<const ScanPoint> points, const Eigen::Vector2d& lidar);

  /// Nothing came back of a beam, and so nothing is nearer than the range [m]. Bearings in which something is known
  /// stay as they are.
  /// @param bearing [rad] in base
  /// @param gap     [rad] to the next beam on either side
  void setOpen(double bearing, double gap, double range);

  /// @param p       [m] a place, in base
  /// @param normal  of the wall there, in base; zero where there is no line
  Visibility visibilityOf(const Eigen::Vector2d& p, const Eigen::Vector2d& normal) const;

 private:
  static constexpr int kBins = 720;
  static constexpr int kTurns = 2 * kBins;                                // added, so that truncation rounds down
  static constexpr double kPerRadian = kBins / (2.0 * std::numbers::pi);  // bins
  struct Bins {
    int first, last;
  };
  static Bins binsOf(double from, double to);
  static Bins binsAround(const Eigen::Vector2d& way, float error);
  template <typename Visit>
  void forBins(const Bins& bins, Visit visit) const;

  RangeImageConfig config_;
  std::array<float, kBins> ranges_{};  // [m] the shortest in the bin; 0: nothing is known
  Eigen::Vector2d lidar_ = Eigen::Vector2d::Zero();
  float farthest_ = 0.0F;  // [m]
};

/// What a scan shows of many places.
struct VisibilityTally {
  int consistent = 0, violated = 0;  ///< places

  void add(RangeImage::Visibility sight) {
    consistent += sight == RangeImage::Visibility::kConsistent;
    violated += sight == RangeImage::Visibility::kViolated;
  }
  int visible() const { return consistent + violated; }
  /// [1] share of the visible places that the scan saw through; 0 where none was visible.
  double freeSpaceViolation() const { return visible() == 0 ? 0.0 : static_cast<double>(violated) / visible(); }
};

}  // namespace slam
