// SPDX-License-Identifier: BSD-3-Clause
#include "app/pose_words.hpp"

#include <iomanip>
#include <numbers>
#include <sstream>

namespace slam {
namespace {

std::string scanWords(const PoseSnapshot& pose, bool has_scans) {
  const TrackingReport& tracking = pose.tracking;
  if (!has_scans) return "waits for the lidar";
  if (pose.scans == 0) return "waits for the first scan";
  if (pose.echo_finding != EchoWatch::Finding::kNone)
    return std::string("waits for echoes: ") + describe(pose.echo_finding);
  if (tracking.range_noise > 0.0)
    return "waits for ranges to match: " + describe({SensorFault::kRangesScatter, tracking.range_noise});
  if (tracking.points < tracking.needed) {
    return "waits for a scan that shows more: the last one has " + std::to_string(tracking.points) + " points where " +
           std::to_string(tracking.needed) + " are needed; walls must be in range (lidar.range_max)";
  }
  return "";
}

}  // namespace

std::string poseWords(const PoseSnapshot& pose, bool has_scans) {
  using enum LocalisationState;
  const LocalisationState state = pose.pose.state;
  if (state == kLocalised) return "";
  const std::string scans = scanWords(pose, has_scans);
  if (state == kLost) {
    return "no pose is published until the robot is found in the map; " +
           (scans.empty() ? "drive slowly on where it has been, or give its place: slamctl set-pose" : scans);
  }
  if (!scans.empty()) return scans;
  if (state == kInitialising) {
    return pose.tracking.begun ? "waits to be found in the map; drive slowly on, or give its place: slamctl set-pose"
                               : "waits for a scan that can be placed";
  }
  std::ostringstream words;
  if (pose.tracking.scan_drift != 0.0) {
    words
        << std::fixed << std::setprecision(1) << "scans turn by "
        << pose.tracking.scan_drift * 60.0 * 180.0 / std::numbers::pi
        << " deg per minute against a gyro that was right at rest: does one half of the scan contradict the other "
           "half, as where two lidars are merged and one is turned, is the lidar loose, or does it see too little? The "
           "pose goes by wheels and gyro until a rest shows that the gyro has changed";
    return words.str();
  }
  if (pose.tracking.failures > 0) {
    return "waits for scans that match the map: the last " + std::to_string(pose.tracking.failures) +
           " do not, the pose goes on by the other sensors; is the lidar covered, or has the place changed?";
  }
  if (pose.tracking.contradiction > 0.0) {
    words
        << std::fixed << std::setprecision(2) << "scans and wheels tell ways that differ by "
        << pose.tracking.contradiction
        << " m, one of them is wrong: was the robot pushed, do its wheels slip, or does someone go along with it? The "
           "pose is sure again some metres after they agree";
    return words.str();
  }
  return "waits for the next scan that matches; the pose goes on by the other sensors";
}

}  // namespace slam
