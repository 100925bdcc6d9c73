// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/dynamic_object_gate.hpp"

namespace slam {

bool DynamicObjectGate::rejects(Timestamp stamp, const Eigen::Vector2d& offset, double support) {
  const bool same = since_ && (offset - place_).norm() < config_.steady;
  if (!same) {
    since_ = stamp;
    place_ = offset;
  }
  if (support < config_.support && toSeconds(stamp - *since_) < config_.patience) {
    last_ = stamp;
    direction_ = offset.normalized();
    return true;
  }
  since_.reset();
  last_.reset();
  return false;
}

bool DynamicObjectGate::stillRejects(Timestamp stamp) {
  since_.reset();
  return last_ && toSeconds(stamp - *last_) < config_.patience;
}

}  // namespace slam
