// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_odometry.hpp"

namespace slam {

const Pose2& WheelOdometry::add(double left, double right) {
  if (last_) {
    const double left_travel = base_.wheel_radius * (left - last_->left);
    const double right_travel = base_.wheel_radius * (right - last_->right);
    pose_ = pose_ * exp({(left_travel + right_travel) / 2.0, 0.0,  //
                         (right_travel - left_travel) / (2.0 * base_.half_track)});
  }
  last_ = Angles{left, right};
  return pose_;
}

}  // namespace slam
