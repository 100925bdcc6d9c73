// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/timestamp.hpp"
#include "estimation/ekf.hpp"
#include "estimation/wheel_monitor.hpp"
#include "frontend/local_map.hpp"
#include "frontend/preprocessor.hpp"
#include "frontend/tracking_state.hpp"
#include "matching/correlative.hpp"
#include "matching/match_result.hpp"

namespace slam {

/// Where the match of a scan starts from, and the search that follows where it leads nowhere.
struct RegistrationConfig {
  int starts = 4;                ///< poses that are tried at most, the prediction first
  double clearly_better = 0.01;  ///< [1] of overlap, between starting poses
  double sudden_loss = 0.03;     ///< [1] of overlap from one scan to the next: the prediction may be wrong
  int most_widened = 8;          ///< failures in a row with each of which the search window grows by itself
};

/// Where the filters put the robot at a scan's stamp, before the scan is known.
struct Prediction {
  Ekf pose, odometry;
};

/// Finds a scan in the local map: PL-ICP [Censi 2008] from one to four starting poses, and the correlative search
/// [Olson 2009] around the prediction where that leads nowhere.
class Registration {
 public:
  Registration(const RegistrationConfig& config, const CorrelativeConfig& search, const SearchWindow& window,
               Stopwatch stopwatch = nullptr);

  MatchResult align(const Cloud& cloud, const LocalMap& local_map, const Prediction& predicted,
                    const TrackingState& tracking, WheelReliability wheels);
  /// The window grows with the failures in a row.
  MatchResult search(const Cloud& cloud, const LocalMap& local_map, const Pose2& predicted, int failures);

  /// Spent in the last align(); 0 without a stopwatch.
  Duration matchTime() const { return match_time_; }
  std::uint32_t searched() const { return searched_; }

 private:
  RegistrationConfig config_;
  SearchWindow window_;
  CorrelativeMatcher search_;
  Stopwatch stopwatch_;
  Duration match_time_{0};
  std::uint32_t searched_ = 0;
};

}  // namespace slam
