// SPDX-License-Identifier: BSD-3-Clause
// How the localizer's scans find their place: guesses, what pulls a match away, and the search where none leads there.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "matching/plicp.hpp"
#include "slam/localizer.hpp"

namespace slam {
namespace {

constexpr double kClearlyBetter = 0.01;  // [1] of overlap, between guesses
constexpr double kSuddenly = 0.03;       // [1] overlap lost from one scan to the next: the guess may be wrong
constexpr double kMuchWorse = 0.12;      // [1] overlap lost by a find: it is another place
constexpr double kSeenThrough = 0.12;    // [1] of the walls in sight; of a right find at most 0.10
constexpr double kKnownSurfel = 4.0;     // [1] observations

}  // namespace

MatchResult Localizer::matchFromGuesses(Timestamp stamp, const Ekf& predicted) const {
  MatchResult best = matchPointToLine(reference_, points_, predicted.pose(), match_);
  const bool wheels_help = has_wheels_ && wheel_trust_.guides() && predicted.doubt() < config_.max_doubt;
  if (wheels_help && best.usable() && best.overlap > overlap_ - kSuddenly) return best;
  // Without wheels the prediction hangs on the scans' stamps, which jitter in many recordings. A robot that went on as
  // between the last two scans, or that stands still, is as likely. And a match that slipping wheels led into a wrong
  // minimum agrees with them: only its overlap tells.
  const auto tryFrom = [&](const Pose2& guess) {
    const MatchResult other = matchPointToLine(reference_, points_, guess, match_);
    if (other.usable() && (!best.usable() || other.overlap > best.overlap + kClearlyBetter)) best = other;
  };
  tryFrom(last_pose_ * last_motion_);
  tryFrom(last_pose_);
  // Wheels whose way is not believed may still tell a turn.
  if (has_wheels_ && !wheel_trust_.believed())
    tryFrom(last_pose_ * between(last_odometry_, odometry_.at(stamp).pose()));
  return best;
}

/// Takes out of a match what something that moves may have made of it: there the wheels tell the way.
void Localizer::holdIfPulled(Timestamp stamp, const Ekf& predicted, MatchResult& match) {
  if (!match.usable() || !has_wheels_ || !wheel_trust_.keepPromise()) return;
  const Pose2 guess = predicted.pose();
  if (pull_watch_.slipped(wrapAngle(match.T_ref_base.theta - guess.theta))) return;
  const Eigen::Vector2d offset = match.T_ref_base.translation() - guess.translation();
  const Eigen::Matrix2d covariance = predicted.covariance().topLeftCorner<2, 2>();
  const double sigma = std::sqrt(offset.dot(covariance * offset)) / std::max(offset.norm(), 1e-9);
  if (pull_watch_.contradicts(offset, sigma) ? !pull_watch_.pulls(stamp, offset, supportOf(match, guess))
                                             : !pull_watch_.stillPulls(stamp)) {
    return;
  }
  ++counters_.scans_held;
  match = heldAlong(match, guess.translation(), pull_watch_.pull());
}

/// Share of the scan that fits better where a match is than where the guess is, less of the walls it sees through.
double Localizer::supportOf(const MatchResult& match, const Pose2& guess) {
  image_.set(points_, config_.lidar.T_base_lidar.translation());
  const auto fit = [&](const Pose2& T_map_base) {
    return overlapAt(reference_, points_, T_map_base, match_.kernel_scale, match_) -
           reference_.seenThrough(T_map_base, image_, kKnownSurfel);
  };
  return fit(match.T_ref_base) - fit({guess.x, guess.y, match.T_ref_base.theta});
}

/// Whether a match from a prediction can be believed. Once the way is lost and the robot may be anywhere around the
/// prediction, what fits there is one place of many.
bool Localizer::isTold(const Ekf& predicted, const MatchResult& match) {
  const Eigen::Vector3d sigma = predicted.covariance().topLeftCorner<3, 3>().diagonal().cwiseSqrt();
  const bool vague =
      sigma.z() > config_.search.distinct_rotation || sigma.head<2>().maxCoeff() > config_.search.distinct_distance;
  return failures_ == 0 || !vague || isFind(match);
}

/// Whether a match can be believed wherever the robot was thought to be. Among many places one fits by half: a find
/// needs more agreement than a prediction does. A room has corners that look like one another: in the right one the
/// scan sees through no walls, and fits about as well as the last one did.
bool Localizer::isFind(const MatchResult& match) {
  if (!match.usable() || match.overlap < config_.search.trusted_overlap) return false;
  image_.set(points_, config_.lidar.T_base_lidar.translation());
  if (reference_.seenThrough(match.T_ref_base, image_, kKnownSurfel) > kSeenThrough) return false;
  return match.overlap >= fused_overlap_ - kMuchWorse || showsMore(match.T_ref_base);
}

/// Whether a scan that fits worse than the last one does so because the robot has turned to what it had not seen: it is
/// no further on than a robot gets from scan to scan, and shows nothing where the newest keyframe saw through.
bool Localizer::showsMore(const Pose2& T_map_base) {
  const Pose2 moved = between(last_pose_, T_map_base);
  if (std::max(std::abs(moved.x), std::abs(moved.y)) > config_.search_window.translation) return false;
  if (std::abs(moved.theta) > config_.search_window.rotation) return false;
  image_.set(newest_points_, config_.lidar.T_base_lidar.translation());
  const PointTransform T_newest_base(between(*last_keyframe_, T_map_base));
  SightTally tally;
  for (const ScanPoint& point : points_) {
    tally.add(image_.sightOf(T_newest_base * point.position, T_newest_base.turned(point.normal)));
  }
  return tally.met >= config_.match.min_pairs && tally.seenThrough() <= kSeenThrough;
}

void Localizer::searchAround(const Pose2& predicted, ScanOutcome& outcome) {
  ++counters_.searched;
  const double widening = 1.0 + std::min(failures_, config_.keyframe.max_failures);
  const SearchWindow window{widening * config_.search_window.translation, widening * config_.search_window.rotation};
  const SearchResult found = search_.match(reference_, points_, predicted, window, match_);
  if (!isFind(found.match)) return;
  outcome.match = found.match;
  outcome.fused = fuse(outcome.stamp, found.match, true);
}

}  // namespace slam
