// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Properties: what holds for all of many drawn values (rapidcheck). The seed is fixed, so that a run is repeatable;
// RC_PARAMS="seed=..." in the environment draws others.
#include <cstdlib>
#include <rapidcheck/gtest.h>

#include "core/pose2.hpp"

namespace slam::test {

inline const int kSeeded = setenv("RC_PARAMS", "seed=1 max_success=200", 0);  // before the first property reads it

/// A number in [low, high], however few values were drawn before it.
inline double draw(double low, double high) {
  constexpr int kSteps = 1 << 20;
  const int step = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, kSteps + 1));
  return low + (high - low) * step / kSteps;
}

/// A pose that far from the origin at most, any heading. @param metres of each coordinate
inline Pose2 drawPose(double metres) {
  const double x = draw(-metres, metres), y = draw(-metres, metres);
  return {x, y, draw(-3.14, 3.14)};
}

}  // namespace slam::test
