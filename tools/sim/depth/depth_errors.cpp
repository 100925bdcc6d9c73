// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_errors.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace slam::sim {
namespace {

// Equation (1) solved for the shift: s = kShiftAtInfinity - kShiftPerInverse / Z[m].
constexpr double kPixel = 0.1052;  // [mm] of the sensor
constexpr double kShiftAtInfinity = 800.0 + 4.0 * (7.5 / kPixel + 0.375);
constexpr double kShiftPerInverse = 4.0 * 9.0 / kPixel;
constexpr int kShifts = 2048;          // 11 bits
constexpr float kSameSurface = 1.03F;  // [1] inverse depths that differ by less do not shade each other

/// A good 64-bit hash (the finaliser of SplitMix64).
std::uint64_t hash(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

}  // namespace

std::uint16_t shiftToDepth(int shift, const DepthErrorModel& model) {
  const double inverse = (kShiftAtInfinity - shift) / kShiftPerInverse;  // [1/m]
  if (inverse * model.farthest < 1.0 || inverse * model.nearest > 1.0) return 0;
  return static_cast<std::uint16_t>(std::lround(1000.0 / inverse));
}

DepthErrors::DepthErrors(const DepthIntrinsics& intrinsics, const DepthErrorModel& model, std::uint64_t seed)
    : intrinsics_(intrinsics), model_(model), seed_(hash(seed)) {
  const auto width = static_cast<std::size_t>(intrinsics.width);
  std::mt19937_64 random(seed_);
  std::normal_distribution<double> normal(0.0, model.noise * kShiftPerInverse);
  noise_.resize(kTable + width);
  for (float& value : noise_) value = static_cast<float>(normal(random));
  lottery_.resize(kTable + width);
  for (std::uint8_t& value : lottery_) value = static_cast<std::uint8_t>(random() >> 56U);
  depth_of_.resize(kShifts);
  for (int shift = 0; shift < kShifts; ++shift) {
    depth_of_[static_cast<std::size_t>(shift)] = shiftToDepth(shift, model);
  }
  shadow_.resize(width);
  projector_.resize(width + 2);
}

/// A surface at column u and 1/Z stands at column u - fx b / Z of the projector's view; only the nearest surface there
/// gets light. Columns that leave the view to the left are lit by a wider pattern.
void DepthErrors::castShadows(const float* row) {
  const auto disparity = static_cast<float>(intrinsics_.fx * model_.baseline);
  const int width = intrinsics_.width;
  std::fill(projector_.begin(), projector_.end(), 0.0F);
  for (int u = 0; u < width; ++u) {
    const float column = static_cast<float>(u) - disparity * row[u];
    if (column < 0.0F) continue;
    const auto i = static_cast<std::size_t>(column);
    projector_[i] = std::max(projector_[i], row[u]);
    projector_[i + 1] = std::max(projector_[i + 1], row[u]);
  }
  for (int u = 0; u < width; ++u) {
    const float column = static_cast<float>(u) - disparity * row[u];
    const auto i = static_cast<std::size_t>(std::max(0.0F, column + 0.5F));
    shadow_[static_cast<std::size_t>(u)] = column >= 0.0F && projector_[i] > kSameSurface * row[u];
  }
}

void DepthErrors::measureRow(const float* row, const float* above, std::uint64_t random, std::uint16_t* depth) {
  const float* const noise = noise_.data() + random % kTable;
  const std::uint8_t* const lottery = lottery_.data() + (random >> 32U) % kTable;
  const auto scale = static_cast<float>(kShiftPerInverse);
  constexpr auto kOffset = static_cast<float>(kShiftAtInfinity + 0.5);  // truncation then rounds
  const auto anywhere = static_cast<int>(256.0 * model_.dropout + 0.5);
  const auto at_edges = static_cast<int>(256.0 * model_.edge_dropout + 0.5);
  const auto step = static_cast<float>(model_.edge_step);
  const auto farthest = static_cast<float>(1.0 / model_.farthest), nearest = static_cast<float>(1.0 / model_.nearest);
  for (int u = 0; u < intrinsics_.width; ++u) {
    const float inverse = row[u], limit = step * inverse;
    const float left = row[std::max(0, u - 1)], right = row[std::min(intrinsics_.width - 1, u + 1)];
    const bool edge =
        std::abs(left - inverse) > limit || std::abs(right - inverse) > limit || std::abs(above[u] - inverse) > limit;
    const int shift = static_cast<int>(kOffset - scale * inverse + noise[u]);
    const bool lost = lottery[u] < (edge ? at_edges : anywhere) || shadow_[static_cast<std::size_t>(u)] != 0 ||
                      inverse < farthest || inverse > nearest;
    depth[u] = lost ? std::uint16_t{0} : depth_of_[static_cast<std::size_t>(std::clamp(shift, 0, kShifts - 1))];
  }
}

void DepthErrors::apply(std::span<const float> inverse_depth, std::uint64_t frame, std::span<std::uint16_t> depth) {
  const auto width = static_cast<std::size_t>(intrinsics_.width);
  for (int v = 0; v < intrinsics_.height; ++v) {
    const float* const row = inverse_depth.data() + static_cast<std::size_t>(v) * width;
    const float* const above = v > 0 ? row - width : row;
    castShadows(row);
    measureRow(row, above, hash(seed_ ^ hash(frame * 4096U + static_cast<std::uint64_t>(v))),
               depth.data() + static_cast<std::size_t>(v) * width);
  }
}

}  // namespace slam::sim
