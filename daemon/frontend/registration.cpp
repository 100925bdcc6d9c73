// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/registration.hpp"

#include <algorithm>

#include "matching/icp.hpp"
#include "matching/plicp.hpp"

namespace slam {

Registration::Registration(const RegistrationConfig& config, const CorrelativeConfig& search,
                           const SearchWindow& window, Stopwatch stopwatch)
    : config_(config), window_(window), search_(search), stopwatch_(stopwatch) {}

MatchResult Registration::align(const Cloud& cloud, const LocalMap& local_map, const Prediction& predicted,
                                const TrackingState& tracking, WheelReliability wheels) {
  const Timestamp begin = stopwatch_ ? stopwatch_() : Timestamp{};
  const auto match = cloud.match.method == MatchMethod::kPointToPoint ? matchPointToPoint : matchPointToLine;
  const auto matchFrom = [&](const Pose2& guess) {
    return match(local_map.reference(), cloud.points, guess, cloud.match);
  };
  MatchResult best = matchFrom(predicted.pose.pose());
  int starts = 1;
  const auto tryFrom = [&](const Pose2& guess) {
    if (starts++ >= config_.starts) return;
    const MatchResult other = matchFrom(guess);
    if (other.usable() && (!best.usable() || other.overlap > best.overlap + config_.clearly_better)) best = other;
  };
  const bool wheels_help = wheels >= WheelReliability::kReliable;
  if (!(wheels_help && best.usable() && best.overlap > tracking.overlap() - config_.sudden_loss)) {
    // Without wheels the prediction hangs on the scans' stamps, which jitter in many recordings. A robot that went on
    // as between the last two scans, or that stands still, is as likely. And a match that slipping wheels led into a
    // wrong minimum agrees with them: only its overlap tells.
    tryFrom(tracking.lastPose() * tracking.lastMotion());
    tryFrom(tracking.lastPose());
    // Wheels whose way is not believed may still tell a turn.
    if (wheels == WheelReliability::kRejected)
      tryFrom(tracking.lastPose() * between(tracking.lastOdometry(), predicted.odometry.pose()));
  }
  if (stopwatch_) match_time_ = stopwatch_() - begin;
  return best;
}

MatchResult Registration::search(const Cloud& cloud, const LocalMap& local_map, const Pose2& predicted, int failures) {
  ++searched_;
  const double widening = 1.0 + std::min(failures, config_.most_widened);
  const SearchWindow window{widening * window_.translation, widening * window_.rotation};
  return search_.match(local_map.reference(), cloud.points, predicted, window, cloud.match).match;
}

}  // namespace slam
