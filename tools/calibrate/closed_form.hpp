// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <span>

#include "tools/calibrate/wheel_model.hpp"

namespace slam {

/// The closed-form solution of [Censi 2013] (see wheel_model.hpp), which needs no first guess.
///
/// Linear estimation of J21 = -r_L/b and J22 = r_R/b from the turns alone, s_theta = J21 phi_L + J22 phi_R. Then, with
/// the paths of the wheels for b = 1 m, (c_x, c_y), and the turns theta known, every motion gives two equations
/// Q phi = 0 in phi = (b, l_x, l_y, cos l_theta, sin l_theta):
///
///     Q = [ -c_x  1 - cos theta    sin theta    s_x  -s_y
///           -c_y   -sin theta    1 - cos theta  s_y   s_x ]
///
/// phi' M phi, M = sum Q' Q / sigma^2, is least on the circle phi_4^2 + phi_5^2 = 1 where (phi_4, phi_5) is the
/// eigenvector to the smaller eigenvalue of M's Schur complement; its sign is the one that makes b positive.
///
/// The covariance of a motion's translation enters as isotropic, which is what keeps the problem quadratic.
///
/// @return std::nullopt when the motions leave one of the two steps singular
std::optional<RobotGeometry> solveClosedForm(std::span<const LidarMotion> motions);

}  // namespace slam
