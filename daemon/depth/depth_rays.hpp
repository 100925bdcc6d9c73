// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "core/depth_image.hpp"
#include "core/pose2.hpp"

namespace slam {

/// Where the depth camera sits on the robot: x forward, y left, z up from the floor below base; roll, pitch and yaw
/// about these axes (applied in the order yaw, pitch, roll; a positive pitch looks down), of the camera looking along
/// x.
struct DepthExtrinsics {
  double x = 0.0, y = 0.0, z = 0.0;           ///< [m]
  double roll = 0.0, pitch = 0.0, yaw = 0.0;  ///< [rad]

  /// The camera levelled to the floor, T_base_depth.
  Pose2 levelled() const { return {x, y, yaw}; }

  void visitSettings(auto& v) {
    v.robot("x", x, "m", -5.0, 5.0, "The camera is mounted this far ahead of the base's turning centre.",
            "Measure it on each robot.");
    v.site("y", y, "m", -5.0, 5.0, "The camera is mounted this far left of the base's turning centre.",
           "Set it when the camera is not in the middle of the robot.");
    v.robot("z", z, "m", 0.0, 3.0,
            "The camera is mounted this far above the floor; its images are not used while this is 0.",
            "Measure it on each robot that has a depth camera.");
    v.expert("roll", roll, "rad", -std::numbers::pi, std::numbers::pi,
             "The camera is rotated by this angle about its optical axis, positive with its right side down.");
    v.robot("pitch", pitch, "rad", -1.2, 1.2, "The camera looks down from the horizontal by this angle.",
            "Measure it on each robot; SLAM_HEALTH names the error that the floor shows.");
    v.expert("yaw", yaw, "rad", -std::numbers::pi, std::numbers::pi,
             "The camera looks to the left of the robot's forward by this angle.");
  }
};

/// The directions in which a depth camera's pixels look, sorted into beams of equal bearing and, within a beam, into
/// bands of rows. In the camera's frame, levelled to the floor by the extrinsics' pitch and roll.
class DepthRays {
 public:
  static constexpr int kBands = 32;  ///< groups of rows

  struct Pixel {
    float across;        ///< [1] distance along the floor per depth
    float up;            ///< [1] height gained per depth
    std::uint16_t beam;  ///< of its bearing
  };
  /// Pixels of one row and beam, side by side.
  struct Run {
    std::uint16_t beam, end;  ///< end: column behind the last one; the first is where the run before ends
  };
  /// Bounds of a row's pixels.
  struct Row {
    float across_low, across_high, up_low, up_high;  ///< [1] per depth
    std::uint32_t first_run, end_run;                ///< of runs()
  };
  /// Pixels of one beam that look up or down alike.
  struct Band {
    float slope_low = 0.0F, slope_high = 0.0F;  ///< [1] height gained per distance along the floor
    int pixels = 0;
  };

  /// @param bearing_step [rad] wanted between two beams @param most beams
  void prepare(const DepthExtrinsics& extrinsics, const DepthIntrinsics& intrinsics, double bearing_step, int most);

  const DepthIntrinsics& intrinsics() const { return intrinsics_; }
  int beams() const { return static_cast<int>(cos_.size()); }
  float bearingMin() const { return bearing_min_; }    ///< [rad] of beam 0
  float bearingStep() const { return bearing_step_; }  ///< [rad]
  float cosine(std::size_t beam) const { return cos_[beam]; }
  float sine(std::size_t beam) const { return sin_[beam]; }

  const Pixel& pixel(std::size_t i) const { return pixels_[i]; }  ///< by row, then column
  const Row& row(std::size_t v) const { return rows_[v]; }
  std::span<const Run> runs(const Row& row) const {
    return std::span(runs_).subspan(row.first_run, row.end_run - row.first_run);
  }
  /// Index of the first beam's band that holds row v; band k of beam b is at b * kBands + k.
  std::size_t bandOfRow(std::size_t v) const { return v * kBands / static_cast<std::size_t>(intrinsics_.height); }
  std::span<const Band> bands(int beam) const {
    return std::span(bands_).subspan(static_cast<std::size_t>(beam) * kBands, kBands);
  }

 private:
  void boundRows();

  DepthIntrinsics intrinsics_;
  float bearing_min_ = 0.0F, bearing_step_ = 0.0F;
  std::vector<float> cos_, sin_;
  std::vector<Pixel> pixels_;
  std::vector<Run> runs_;
  std::vector<Row> rows_;
  std::vector<Band> bands_;
};

}  // namespace slam
