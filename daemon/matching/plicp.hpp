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
/// @param reference  surfels in the reference frame
/// @param points     new scan in base, deskewed, with normals where a line was found (they tell wall faces apart)
/// @param guess      first T_ref_base, expected within initial_pair_distance of the truth
/// @return           never throws; see MatchStatus
///
/// Pure: no state, no allocation, safe from any thread. O(|points|) per iteration.
/// [Censi 2008] A. Censi, "An ICP variant using a point-to-line metric", Proc. ICRA 2008.
MatchResult matchPointToLine(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                             const MatchConfig& config = {}) noexcept;

}  // namespace slam
