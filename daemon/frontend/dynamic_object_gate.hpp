// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

struct DynamicObjectGateConfig {
  double noticeable = 0.05;    ///< [m] a match nearer to where the wheels put the robot contradicts nobody
  double contradiction = 2.0;  ///< [1] nor one within so many standard deviations of it
  double support = 0.15;       ///< [1] share of the scan that fits better there: more than a person nearby has
  double steady = 0.04;        ///< [m] walls pull to the same place ...
  double patience = 1.0;       ///< [s] ... for so long; who walks does not
};

/// Whether something that moves pulls a match away from where the wheels put the robot. Along a bare corridor a person
/// who walks by is all that tells the way: the scan fits at either place, but for the points on the person. So a match
/// off the wheels' place is believed when much of the scan speaks for it, or when it points to one place for a while.
class DynamicObjectGate {
 public:
  explicit DynamicObjectGate(const DynamicObjectGateConfig& config = {}) : config_(config) {}

  /// @param offset [m] from where the wheels put the robot to where the match does
  /// @param sigma  [m] the prediction's standard deviation along it
  bool contradicts(const Eigen::Vector2d& offset, double sigma) const {
    return offset.norm() > std::max(config_.noticeable, config_.contradiction * sigma);
  }
  /// To be asked about each match that contradicts().
  /// @param support [1] share of the scan that fits better where the match is than where the wheels put the robot
  /// @return whether the match is not to be believed along the offset
  bool rejects(Timestamp stamp, const Eigen::Vector2d& offset, double support);
  /// A match did not contradict the wheels. @return whether it is not to be believed along direction() all the same:
  /// who pulled a moment ago is still there, and pulls by little, too
  bool stillRejects(Timestamp stamp);
  /// Unit vector along the last offset that was not believed.
  const Eigen::Vector2d& direction() const { return direction_; }

 private:
  DynamicObjectGateConfig config_;
  std::optional<Timestamp> since_, last_;            // of offsets that are alike, of the last pull
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero();  // [m] the first of those offsets
  Eigen::Vector2d direction_ = Eigen::Vector2d::UnitX();
};

}  // namespace slam
