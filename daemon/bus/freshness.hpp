// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "core/timestamp.hpp"
#include "problems/devices.hpp"

namespace slam {

inline constexpr Duration kFarAhead = std::chrono::seconds(1);  ///< a stamp this far in the future is wrong
inline constexpr Duration kOldCommand = std::chrono::milliseconds(500);

/// Whether somebody else's sample can have been taken at `stamp`.
inline bool isPossible(Timestamp stamp, Timestamp now) { return stamp <= now + kFarAhead; }

/// Whether a speed asked for at `sent` is still driven: what was delayed on its way must not move the robot.
inline bool isFreshCommand(Timestamp sent, Timestamp now) { return sent > now - kOldCommand && sent < now + kFarAhead; }

/// What is wrong with stamps of such an age: a log that is played, or a computer whose clock differs.
/// @param age of the newest sample; below zero: from the future @param differs the clocks do, by more than a delay
inline Problem stampProblem(Duration age, bool differs) {
  constexpr Duration kOldSample = std::chrono::seconds(5);  // none that is on its way, nor one that the filter can use
  if (!differs && age < kOldSample && age >= -kFarAhead) return {};
  return {age > Duration(0) ? problem::kStampsOld : problem::kStampsAhead, {std::abs(toSeconds(age))}};
}

}  // namespace slam
