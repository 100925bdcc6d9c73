// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/depth_image.hpp"

namespace slam::sim {

/// How an Asus Xtion measures depth. It triangulates a projected pattern, so what it measures is the shift s of the
/// pattern, which is affine in 1/Z; with the reference plane at 1.2 m [OpenNI2 2.2, XnShiftToDepth.cpp],
///
///     m = ((s - 800)/4 - 0.375) 0.1052 mm,   Z = 9000 mm^2 / (7.5 mm - m).                                   (1)
///
/// The random error of Z, 1.43e-6 Z^2 [mm] [Khoshelham and Elberink 2012], is to first order an error of 1/Z, thus of
/// s, that is the same at any range: the noise is added there, before the rounding to whole shifts. [Khoshelham and
/// Elberink 2012] "Accuracy and resolution of Kinect depth data for indoor mapping applications", Sensors 12(2).
struct DepthErrorModel {
  double nearest = 0.5, farthest = 8.0;  ///< [m] no data beyond
  double noise = 1.43e-3;                ///< [1/m] standard deviation of 1/Z
  double baseline = 0.075;               ///< [m] projector right of the camera: its shadows fall to the left
  double dropout = 0.015;                ///< [1] share of pixels without data ...
  double edge_dropout = 0.5;             ///< [1] ... and of those beside a step of the depth
  double edge_step = 0.05;               ///< [1] change of depth from one pixel to the next that is a step, relative
};

/// Turns true inverse depth into what the camera would report. Deterministic: seed and frame index give the same noise
/// whatever was asked for before.
class DepthErrors {
 public:
  DepthErrors(const DepthIntrinsics& intrinsics, const DepthErrorModel& model, std::uint64_t seed);

  /// @param inverse_depth [1/m]; 0: nothing there
  /// @param depth         [mm], 0: no data
  void apply(std::span<const float> inverse_depth, std::uint64_t frame, std::span<std::uint16_t> depth);

 private:
  static constexpr std::size_t kTable = 1U << 16U;

  void castShadows(const float* row);
  void measureRow(const float* row, const float* above, std::uint64_t random, std::uint16_t* depth);

  DepthIntrinsics intrinsics_;
  DepthErrorModel model_;
  std::uint64_t seed_;
  std::vector<float> noise_;             // [shift] drawn in advance, kTable and a row
  std::vector<std::uint8_t> lottery_;    // uniform bytes, kTable and a row
  std::vector<std::uint16_t> depth_of_;  // [mm] of each shift
  std::vector<float> projector_;         // [1/m] nearest surface per column of the projector's view
  std::vector<std::uint8_t> shadow_;     // 1: the pattern does not reach this pixel of the row
};

/// What (1) gives for a whole shift. @return [mm], rounded; 0 for what is not in the camera's reach
std::uint16_t shiftToDepth(int shift, const DepthErrorModel& model);

}  // namespace slam::sim
