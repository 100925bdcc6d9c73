// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "app/threads/thread_messages.hpp"

namespace slam {

/// What a pose that is not localised waits for, and what helps; empty: it is.
/// @param has_scans the lidar gives some
std::string poseWords(const PoseSnapshot& pose, bool has_scans);

}  // namespace slam
