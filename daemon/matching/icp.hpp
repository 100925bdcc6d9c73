// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "matching/match_result.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// Iterative closest point, the paper's baseline (section II.A): pairs by the nearest point, then R and t that minimise
///
///     E(R, t) = 1/k sum_n |x_n - (R p_n + t)|^2                       (1)
///
/// in closed form by the SVD of W = sum_n p'_n x'_n^T about the centroids, eq. (3)-(5).
/// Parameters and result as in matchPointToLine(). Its covariance counts each pair as a fix of both coordinates.
MatchResult matchPointToPoint(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                              const MatchConfig& config = {}) noexcept;

}  // namespace slam
