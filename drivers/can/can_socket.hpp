// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/can/can_port.hpp"

namespace slam {

/// A raw SocketCAN socket. Stamps are the kernel's receive times, brought from its wall clock to the clock of `now`.
/// @param now CLOCK_MONOTONIC
std::unique_ptr<CanPort> makeSocketCanPort(Timestamp (*now)());

/// Maps a stamp of the wall clock to ours by its age; an age that cannot be (the wall clock was set) counts as none.
/// @param wall_now, now the two clocks at one moment
Timestamp stampFromWallClock(Duration wall_stamp, Duration wall_now, Timestamp now);

}  // namespace slam
