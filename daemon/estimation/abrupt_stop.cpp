// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/abrupt_stop.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace slam {

void AbruptStop::move(const Eigen::Vector2d& velocity) {
  previous_ = quiet_ > 0 ? Eigen::Vector2d::Zero().eval() : last_;
  last_ = velocity;
  quiet_ = 0;
  speed_ = 0.0;
  dead_ = false;
}

bool AbruptStop::stand(double braking, double seconds, Timestamp stamp, const Pose2& T_map_base) {
  const double before = std::min(previous_.norm(), last_.norm());
  if (++quiet_ != 2 || before <= braking * seconds) return false;
  speed_ = before;
  beginAt(stamp, T_map_base);
  return true;
}

void AbruptStop::decide(Timestamp stamp, const Pose2& T_map_base, double unknown) {
  if (!doubtful() || dead_) return;
  const double turn = wrapAngle(T_map_base.theta - T_map_stop_.theta);  // the chord of an arc lies at half of it
  const Eigen::Vector2d drive =
      toSeconds(stamp - stamp_) * (Eigen::Rotation2Dd(T_map_stop_.theta + 0.5 * turn) * last_);
  const double half = 0.5 * drive.norm();
  if (half < unknown) return;
  dead_ = (T_map_base.translation() - T_map_stop_.translation() - drive).norm() < half;
  if (!dead_) speed_ = 0.0;
}

}  // namespace slam
