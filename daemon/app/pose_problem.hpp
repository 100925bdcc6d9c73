// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "app/log/trouble_log.hpp"
#include "app/threads/thread_messages.hpp"

namespace slam {

/// What a pose that is not localised waits for; no problem: it is.
/// @param has_scans the lidar gives some
Trouble poseTrouble(const PoseSnapshot& pose, bool has_scans);

}  // namespace slam
