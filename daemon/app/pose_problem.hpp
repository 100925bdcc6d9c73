// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <utility>
#include <vector>

#include "app/log/trouble_log.hpp"
#include "app/threads/thread_messages.hpp"

namespace slam {

/// What a pose that is not localised waits for; no problem: it is.
/// @param has_scans the lidar gives some
Trouble poseTrouble(const PoseSnapshot& pose, bool has_scans);

/// How long there has been no pose.
class PoseWatch {
 public:
  /// For the log. Every drive begins without a pose, and single scans do not match: that is no trouble for a while.
  /// @param has_scans as of poseTrouble() @return none where it is localised, one without a problem where that matters
  /// not
  std::vector<Trouble> troubles(const PoseSnapshot& pose, bool has_scans, Timestamp now);
  /// Whether it is localised for the first time.
  bool isFirst(const PoseSnapshot& pose) {
    return pose.pose.state == LocalisationState::kLocalised && !std::exchange(localised_, true);
  }

 private:
  std::optional<Timestamp> unlocalised_since_;
  bool localised_ = false;
};

}  // namespace slam
