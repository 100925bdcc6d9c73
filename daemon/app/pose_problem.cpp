// SPDX-License-Identifier: BSD-3-Clause
#include "app/pose_problem.hpp"

#include <numbers>

#include "diagnostics/sensor_problems.hpp"
#include "problems/daemon.hpp"

namespace slam {
namespace {

Problem scanProblem(const PoseSnapshot& pose, bool has_scans) {
  const TrackingReport& tracking = pose.tracking;
  if (tracking.begun && tracking.silent) return problem::kNoSource;
  if (!has_scans) return problem::kNoScans;
  if (pose.scans == 0) return problem::kNoScanYet;
  if (pose.echo_finding != EchoWatch::Finding::kNone) return problemOf(pose.echo_finding);
  if (tracking.range_noise > 0.0) return problemOf({SensorFault::kRangesScatter, tracking.range_noise});
  if (tracking.points < tracking.needed)
    return {problem::kFewPoints, {static_cast<double>(tracking.points), static_cast<double>(tracking.needed)}};
  return {};
}

Problem problemOf(const TrackingReport& tracking, LocalisationState state) {
  if (state == LocalisationState::kLost) return problem::kLost;
  if (state == LocalisationState::kInitialising) return tracking.begun ? problem::kNotFoundYet : problem::kNoScanPlaced;
  if (tracking.scan_drift != 0.0) return {problem::kScansTurn, {tracking.scan_drift * 60.0 * 180.0 / std::numbers::pi}};
  if (tracking.failures > 0) return {problem::kNoMatch, {static_cast<double>(tracking.failures)}};
  if (tracking.assumed) return problem::kFloorOpen;
  if (tracking.contradiction > 0.0) return {problem::kWaysDiffer, {tracking.contradiction}};
  return problem::kNextScan;
}

}  // namespace

Trouble poseTrouble(const PoseSnapshot& pose, bool has_scans) {
  const LocalisationState state = pose.pose.state;
  Trouble trouble{.device = "pose", .begin = std::string("pose ") + nameOf(state), .recovery = "pose localised"};
  if (state == LocalisationState::kLocalised) return trouble;
  trouble.begin += ": ";
  const Problem scans = scanProblem(pose, has_scans);
  trouble.problem = scans ? scans : problemOf(pose.tracking, state);
  if (state == LocalisationState::kLost && scans && !scans.is(problem::kNoSource))
    trouble.since = problem::kLost.cause + std::string("; ");
  if (scans.is(problem::kRangesScatter)) trouble.since += "waits for ranges to match: ";
  if (scans && scans.isSame(problemOf(pose.echo_finding))) trouble.since += "waits for echoes: ";
  return trouble;
}

std::vector<Trouble> PoseWatch::troubles(const PoseSnapshot& pose, bool has_scans, Timestamp now) {
  constexpr Duration kPoseWaits = std::chrono::seconds(4);  // without a pose, before it is logged
  const LocalisationState state = pose.pose.state;
  if (state == LocalisationState::kLocalised) return unlocalised_since_.reset(), std::vector<Trouble>{};
  if (!unlocalised_since_) unlocalised_since_ = now;
  Trouble trouble = poseTrouble(pose, has_scans);
  if (state != LocalisationState::kLost && now - *unlocalised_since_ < kPoseWaits) trouble.problem = {};
  return {trouble};
}

}  // namespace slam
