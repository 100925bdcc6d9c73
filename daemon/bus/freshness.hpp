// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/timestamp.hpp"

namespace slam {

inline constexpr Duration kFarAhead = std::chrono::seconds(1);  ///< a stamp this far in the future is wrong
inline constexpr Duration kOldCommand = std::chrono::milliseconds(500);

/// Whether somebody else's sample can have been taken at `stamp`.
inline bool isPossible(Timestamp stamp, Timestamp now) { return stamp <= now + kFarAhead; }

/// Whether a speed asked for at `sent` is still driven: what was delayed on its way must not move the robot.
inline bool isFreshCommand(Timestamp sent, Timestamp now) { return sent > now - kOldCommand && sent < now + kFarAhead; }

}  // namespace slam
