// SPDX-License-Identifier: BSD-3-Clause
// What holds for any poses.
#include <Eigen/Core>
#include <cmath>
#include <gtest/gtest.h>

#include "core/pose2.hpp"
#include "core/pose_history.hpp"
#include "support/property.hpp"

namespace slam::pose2_property_test {
namespace {

using test::draw;
using test::drawPose;

bool same(const Pose2& a, const Pose2& b, double tolerance = 1e-9) {
  return std::hypot(a.x - b.x, a.y - b.y) < tolerance && std::abs(wrapAngle(a.theta - b.theta)) < tolerance;
}

RC_GTEST_PROP(Pose2Property, ARelativePoseStaysAsTheMapIsMoved, ()) {
  const Pose2 a = drawPose(20.0), b = drawPose(20.0), T_new_map = drawPose(100.0);
  RC_ASSERT(same(between(T_new_map * a, T_new_map * b), between(a, b)));
  RC_ASSERT(same(between(a, b), between(b, a).inverse()));
  RC_ASSERT(same(a * b.inverse(), (b * a.inverse()).inverse()));
}

RC_GTEST_PROP(Pose2Property, TheJacobiansObeyTheChainRule, ()) {
  const Pose2 a = drawPose(20.0), b = drawPose(20.0);
  const BinaryJacobians there = composeJacobians(a, b), back = betweenJacobians(a, a * b);
  // between(a, a * b) is b, whatever a is.
  RC_ASSERT((back.second * there.second - Eigen::Matrix3d::Identity()).norm() < 1e-9);
  RC_ASSERT((back.first + back.second * there.first).norm() < 1e-9);
  RC_ASSERT((inverseJacobian(a.inverse()) * inverseJacobian(a) - Eigen::Matrix3d::Identity()).norm() < 1e-9);
}

RC_GTEST_PROP(Pose2Property, AWayAtOneTwistIsAsLongInTwoParts, ()) {
  const Eigen::Vector3d twist(draw(-2, 2), draw(-2, 2), draw(-3.1, 3.1));
  const double share = draw(0.0, 1.0);
  RC_ASSERT(same(exp(share * twist) * exp((1.0 - share) * twist), exp(twist)));
  const Pose2 from = drawPose(20.0);
  RC_ASSERT(same(interpolate(from, from * exp(twist), share), from * exp(share * twist)));
}

}  // namespace
}  // namespace slam::pose2_property_test
