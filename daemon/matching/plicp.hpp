// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "matching/match_result.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// Finds the pose of a scan in the reference by minimising the point-to-line error, eq. (6) of the paper [Censi 2008]
///
///     J(R, t) = sum_i w_i e_i^2,    e_i = n_i . (R p_i + t - q_i)
///
/// where q_i is the surfel nearest to R p_i + t, n_i its normal and w_i = (1 + (e_i/kernel_scale)^2)^-1
/// (Cauchy). Each iteration searches the pairs within a gate that narrows, then takes one Gauss-Newton step with
/// J_i = [n_i^T, n_i . R' p_i].
///
/// Normals are estimated from noisy points, and their errors feign information along a wall: the expected share,
/// sum w sigma_n^2 [t, t . R' p][..]^T with t along the wall, is taken off the normal equations before their
/// eigenvalues are judged. Directions in which less than min_information of the pairs remains are blind: no step is
/// taken along them, and the result names them.
///
/// The covariance is variance (sum w J^T J)^-1, where w holds the surfels' own errors beside the points'. The pairs of
/// points in a row (grazing beams, walls too noisy for a line) feign information, too, so the weakest direction is put
/// to the test at the end: displaced by a surfel either way and paired anew, does the gradient change as H says? Its
/// standard deviation grows by the inverse of the share that it does; where next to nothing is left it is blind. What
/// the pose moved along degenerate directions before they were known is taken back.
///
/// @param reference  surfels in the reference frame
/// @param points     new scan in base, deskewed, with normals where a line was found (they tell wall faces apart)
/// @param guess      first T_ref_base, expected within initial_pair_distance of the truth
/// @return           never throws; see MatchStatus
///
/// Pure: no state, no allocation, safe from any thread. O(|points|) per iteration.
/// [Censi 2008] A. Censi, "An ICP variant using a point-to-line metric", Proc. ICRA 2008.
MatchResult matchPointToLine(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                             const MatchConfig& config = {}) noexcept;

/// Share of the points within `distance` [m] of their partner's line when the scan lies at a pose, 0..1: what
/// MatchResult::overlap is at the end of a match, for MatchConfig::overlap_distance.
double overlapAt(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                 double distance, const MatchConfig& config = {}) noexcept;

}  // namespace slam
