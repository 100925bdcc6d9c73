// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "core/pose_covariance.hpp"
#include "matching/match_result.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// How systematic errors of the lidar move the pose at which a scan meets the reference. An error of one unit moves
/// each point along its line's normal by a_i, and has moved the line by s_i when it was drawn, so that the match moves
/// by
///
///     S = S_0 - H^-1 sum_i w_i J_i^T (n_i . a_i - s_i),    H = sum_i w_i J_i^T J_i
///
/// where a_i holds what the sensitivity S_0 of the prediction does to the point. What two walls that face each other
/// pull apart cancels, and so does what the map was drawn with.
///
/// @param points of the scan that `match` is of
/// @param predicted sensitivity of the pose before it: it stays along directions that the match does not see
/// @return the sensitivity of match.T_ref_base, in the reference
///
/// Pure: no state, no allocation. O(|points|).
Sensitivity sensitivityOf(const Reference& reference, std::span<const ScanPoint> points, const MatchResult& match,
                          const Sensitivity& predicted, const MatchConfig& config = {});

}  // namespace slam
