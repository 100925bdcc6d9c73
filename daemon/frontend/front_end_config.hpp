// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/counter_info.hpp"
#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "estimation/ekf_timeline.hpp"
#include "estimation/gyro_monitor.hpp"
#include "estimation/heading_monitor.hpp"
#include "estimation/scan_monitor.hpp"
#include "estimation/wheel_monitor.hpp"
#include "frontend/dynamic_object_gate.hpp"
#include "frontend/dynamic_point_filter.hpp"
#include "frontend/interpreter/body_watch.hpp"
#include "frontend/interpreter/no_return_watch.hpp"
#include "frontend/interpreter/range_noise_watch.hpp"
#include "frontend/interpreter/stuck_scan_detector.hpp"
#include "frontend/interpreter/sweep_watch.hpp"
#include "matching/correlative.hpp"
#include "matching/deskew.hpp"
#include "matching/match_result.hpp"
#include "matching/normals.hpp"
#include "matching/reference.hpp"
#include "timing/stamp_sequencer.hpp"

namespace slam {

/// Bearings as a scan's beams have them, counter-clockwise from one to the other [deg].
struct BearingRange {
  double from = 0.0, to = 0.0;  ///< to >= from
  friend bool operator==(const BearingRange&, const BearingRange&) = default;
};

/// Extrinsics of the lidar and what its readings are worth.
struct LidarModel {
  Pose2 T_base_lidar;
  bool upside_down = false;        ///< its bearings grow clockwise, seen from above
  double range_min = 0.15;         ///< [m] shorter returns are not obstacles
  double range_max = 12.0;         ///< [m] longer returns are not trusted
  double range_sigma = 0.015;      ///< [m] standard deviation of one range
  double time_offset = 0.0;        ///< [s] added to the lidar's stamps
  std::vector<BearingRange> mask;  ///< where the robot itself is seen

  LidarMounting mounting() const { return {T_base_lidar, upside_down}; }
  /// Where the scan knows better it says so.
  RangeLimits limitsFor(const LaserScan& scan) const {
    return {std::max(scan.range_min, static_cast<float>(range_min)),
            std::min(scan.range_max, static_cast<float>(range_max))};
  }

  void visitSettings(auto& v) {
    v.robot("x", T_base_lidar.x, "m", -5.0, 5.0, "The lidar is mounted this far ahead of the base's turning centre.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("y", T_base_lidar.y, "m", -5.0, 5.0, "The lidar is mounted this far left of the base's turning centre.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("yaw", T_base_lidar.theta, "rad", -std::numbers::pi, std::numbers::pi,
            "The lidar's zero direction is turned by this angle to the left of the robot's forward.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("upside_down", upside_down,
            "The lidar is mounted top down, so that its bearings grow clockwise when they are seen from above.",
            "Set true when the lidar hangs from a plate.");
    v.site("range_min", range_min, "m", 0.0, 10.0, "Lidar returns that are nearer than this are ignored.",
           "Raise it when the lidar sees parts of the robot.");
    v.site("range_max", range_max, "m", 0.5, 200.0, "Lidar returns that are farther than this are ignored.",
           "Set it to the range up to which the lidar's data sheet gives an accuracy.");
    v.expert("range_sigma", range_sigma, "m", 0.0005, 0.5, "One range of the lidar has this standard deviation.");
    v.site("mask", mask,
           "Beams at these bearings are left out: pairs of a first and a last angle, counter-clockwise from the "
           "lidar's zero direction.",
           "Set it where the lidar sees parts of the robot that slamd does not find by itself.");
    v.expert("time_offset", time_offset, "s", -1.0, 1.0, "This time is added to the stamps of the lidar's scans.");
  }
};

/// Which samples are no measurement of now.
struct IntakeConfig {
  StampConfig stamps;
  ScanRepeatConfig repeats;
  BodyWatchConfig body;
  NoReturnConfig no_return;
  RangeNoiseConfig range_noise;
  SweepWatchConfig sweep;
  double fastest_turn = 0.02;  ///< [s] no lidar turns faster ...
  double soonest_scan = 0.6;   ///< [1] ... nor in less than this share of the usual interval: a copy
  double moving_speed = 0.02;  ///< [m/s] from here on no sensor sees the same twice ...
  double moving_turn = 0.05;   ///< [rad/s] ... nor from here on
};

/// Where the match of a scan starts from, and the search that follows where it leads nowhere.
struct RegistrationConfig {
  int starts = 4;                ///< poses that are tried at most, the prediction first
  double clearly_better = 0.01;  ///< [1] of overlap, between starting poses
  double sudden_loss = 0.03;     ///< [1] of overlap from one scan to the next: the prediction may be wrong
  double widening = 1.0;         ///< [1] of the search window, with each failure
};

/// Which matches are believed.
struct ValidatorConfig {
  double gyro_error = 0.1;             ///< [rad] of a turn by the gyro, beside three of its standard deviations
  double much_worse = 0.12;            ///< [1] overlap lost by a find: it is another place
  double free_space_violation = 0.12;  ///< [1] of the walls in sight; of a right find at most 0.10
  double known_surfel = 4.0;           ///< [1] observations
  double walls_in_the_open = 0.4;  ///< [1] of a scan's points on walls that stand where earlier scans saw through ...
  double in_the_open_for = 3.0;    ///< [s] ... so long: the robot was carried away
};

/// When a scan is kept for reference and map.
struct KeyframeConfig {
  double translation = 0.20;  ///< [m] since the last keyframe
  double rotation = 0.17;     ///< [rad] since the last keyframe
  double known_ratio = 0.80;  ///< [1] a scan that shows this share of well-known surfels adds nothing: it is a refresh
  double refresh_period = 1.0;  ///< [s] between refreshes of a robot that stands still in a known place
  double overlap = 0.70;        ///< [1] share of points that meet the reference: fewer makes a keyframe ...
  double soon = 0.25;           ///< [1] ... after this share of the usual motion
  int max_failures = 8;         ///< scans in a row without a match, and `degraded_after`: then one is kept as predicted

  void visitSettings(auto& v) {
    v.expert("translation", translation, "m", 0.01, 10.0,
             "A scan becomes a keyframe when the robot is this far from the last keyframe.");
    v.expert("rotation", rotation, "rad", 0.01, std::numbers::pi,
             "A scan becomes a keyframe when the robot has turned this far since the last keyframe.");
    v.expert("overlap", overlap, "1", 0.0, 1.0,
             "A scan becomes a keyframe at once when a smaller share of its points meets the local map.");
    v.expert("known_ratio", known_ratio, "1", 0.0, 1.0,
             "A scan with this share of points on well-known surfels adds no keyframe to the map.");
    v.expert("refresh_period", refresh_period, "s", 0.1, 3600.0,
             "A robot that stands still in a known place draws a scan into the occupancy grid this often.");
    v.expert("max_failures", max_failures, "", 1, 10000,
             "One scan is kept at the filter's pose after this many scans in a row that could not be matched.");
  }
};

/// How the pose drifts from keyframe to keyframe while scans are matched; a random walk of strength q has standard
/// deviation q * sqrt(distance). Without matches, and along degenerate directions, the wheels' noise counts instead.
struct DriftConfig {
  double translation = 0.01;           ///< [m per sqrt(m)]
  double rotation_per_metre = 0.001;   ///< [rad per sqrt(m)]
  double rotation_per_radian = 0.003;  ///< [rad per sqrt(rad)]

  void visitSettings(auto& v) {
    v.expert("drift_translation", translation, "m per sqrt(m)", 1e-4, 1.0,
             "The position from matched scans has this standard deviation after one metre.");
    v.expert("drift_rotation_per_metre", rotation_per_metre, "rad per sqrt(m)", 1e-5, 1.0,
             "The heading from matched scans has this standard deviation after one metre.");
    v.expert("drift_rotation_per_radian", rotation_per_radian, "rad per sqrt(rad)", 1e-5, 1.0,
             "The heading from matched scans has this standard deviation after a turn of one radian.");
  }
};

/// When what the depth camera sees is drawn. Views from one place have the same errors: many of them prove no more than
/// one, but they show what has changed there.
struct DepthViewConfig {
  double time_offset = 0.0;   ///< [s] added to the camera's stamps
  double translation = 0.05;  ///< [m] since the last view
  double rotation = 0.05;     ///< [rad] since the last view
  double period = 0.2;        ///< [s] since the last view

  void visitSettings(auto& v) {
    v.expert("time_offset", time_offset, "s", -1.0, 1.0, "This time is added to the stamps of the depth images.");
  }
};

struct FrontEndConfig {
  LidarModel lidar;
  double wheel_time_offset = 0.0, imu_time_offset = 0.0;  ///< [s] added to the stamps
  DepthViewConfig depth;
  IntakeConfig intake;
  double scan_moment = 0.5;  ///< [1] of a turn, when a scan's pose is found
  EkfConfig ekf;
  EkfTimelineConfig timeline;
  NormalConfig normals;
  DynamicPointFilterConfig dynamic_points;
  ReferenceConfig reference;
  MatchConfig match;
  CorrelativeConfig search;
  SearchWindow search_window;  ///< around the prediction, after a failed match; grows with each further failure
  WheelMonitorConfig wheel_monitor;
  GyroMonitorConfig gyro_monitor;
  ScanMonitorConfig scan_monitor;
  HeadingMonitorConfig heading_monitor;
  DynamicObjectGateConfig dynamic_object_gate;
  RegistrationConfig registration;
  ValidatorConfig validator;
  KeyframeConfig keyframe;
  DriftConfig drift;
  bool follows_nearest = true;       ///< a correction moves the pose as the nearest keyframe; false: as the newest
  bool localise_only = false;        ///< the map is given: scans do not extend it
  double degraded_after = 1.0;       ///< [s] without a matched scan
  double lost_position_sigma = 1.0;  ///< [m] a position this uncertain is not valid

  void visitSettings(auto& v) {
    v.section("ekf", "Kalman filter of wheels and IMU");
    ekf.visitSettings(v);
    timeline.visitSettings(v);
    v.section("match", "matching of scans against the local map");
    match.visitSettings(v);
    v.section("reference", "local map that scans are matched against");
    reference.visitSettings(v);
    v.section("keyframe", "choice of the scans that are kept for local map and map");
    keyframe.visitSettings(v);
    v.section("search", "search for a scan whose prediction leads to no match");
    search_window.visitSettings(v);
    wheel_monitor.visitSettings(v);
    search.visitSettings(v);
    v.section("localisation", "limits of a degraded and of a lost pose");
    v.expert("degraded_after", degraded_after, "s", 0.1, 60.0,
             "The pose is degraded after this time without a matched scan.");
    v.expert("lost_position_sigma", lost_position_sigma, "m", 0.05, 100.0,
             "A position with a larger standard deviation than this is not valid.");
  }
};

struct FrontEndCounters {
  std::uint32_t scans = 0, matched = 0, partly_observable = 0, unmatched = 0, gated = 0, searched = 0, scans_held = 0;
  std::uint32_t scans_too_late = 0, scans_repeated = 0, scans_retimed = 0, clock_resets = 0;
  std::uint32_t samples_late = 0, samples_too_old = 0, far_ahead = 0, implausible = 0, far_off = 0;
  std::uint32_t keyframes = 0, lost = 0, views = 0, views_unplaced = 0, wheels_rejected = 0;
  std::uint32_t gyro_rejected = 0;
  bool wheels_reliable = true;  ///< now
  double wheels_scale = 1.0;

  template <typename Visitor>
  friend void visitCounters(const FrontEndCounters& c, Visitor&& visit) {
    visit(CounterInfo{"scans", "scans", "Scans that were taken in."}, c.scans);
    visit(CounterInfo{"scans.matched", "scans", "Matched in all directions.", "matched"}, c.matched);
    visit(CounterInfo{"scans.partly_observable", "scans", "Matched, but not in all directions.", "partly_observable"},
          c.partly_observable);
    visit(CounterInfo{"scans.unmatched", "scans", "No match was found.", "unmatched"}, c.unmatched);
    visit(CounterInfo{"scans.gated", "scans", "The filter refused their match.", "gated"}, c.gated);
    visit(CounterInfo{"scans.searched", "scans", "Their prediction led to no match and they were searched for.",
                      "searched"},
          c.searched);
    visit(CounterInfo{"scans.held", "scans", "Something moving pulled their match, which was held to the wheels' way."},
          c.scans_held);
    visit(CounterInfo{"scans.too_late", "scans", "Older than the filter's window."}, c.scans_too_late);
    visit(CounterInfo{"scans.repeated", "scans", "Copies of the scan before them, which were not used."},
          c.scans_repeated);
    visit(CounterInfo{"scans.retimed", "scans", "Their stamp was not after its predecessor's."}, c.scans_retimed);
    visit(CounterInfo{"clock_resets", "times", "Stamps jumped back by seconds."}, c.clock_resets);
    visit(CounterInfo{"samples.late", "samples", "Wheel and IMU samples fused at their place behind newer ones."},
          c.samples_late);
    visit(CounterInfo{"samples.too_old", "samples", "Wheel and IMU samples dropped as too old."}, c.samples_too_old);
    visit(CounterInfo{"samples.far_ahead", "samples", "Dropped because their stamp alone was seconds ahead."},
          c.far_ahead);
    visit(CounterInfo{"samples.implausible", "samples",
                      "Wheel and IMU samples dropped: a number was beyond all that can be."},
          c.implausible);
    visit(CounterInfo{"poses.far_off", "times", "The pose had drifted beyond where a map can reach."}, c.far_off);
    visit(CounterInfo{"keyframes", "keyframes", "Keyframes that the front end has made."}, c.keyframes);
    visit(CounterInfo{"lost", "times", "The place in the map was lost, or given by a person."}, c.lost);
    visit(CounterInfo{"views", "images", "Depth images that were drawn."}, c.views);
    visit(CounterInfo{"views.unplaced", "images",
                      "Depth images dropped because the pose at their stamp was not valid or known."},
          c.views_unplaced);
    visit(CounterInfo{"wheels.rejected", "times", "The wheels contradicted the scans too much to be used."},
          c.wheels_rejected);
    visit(CounterInfo{"wheels.withdrawn", "times", "Old name of wheels.rejected, in this release still."},
          c.wheels_rejected);
    visit(CounterInfo{"gyro.rejected", "times", "The gyro contradicted scans and wheels too much to be used."},
          c.gyro_rejected);
    visit(CounterInfo{"wheels.scale", "1", "The wheels' way is divided by it, as the scans have shown so far."},
          c.wheels_scale);
  }
};

/// What a FrontEnd knows of its place, for words.
struct TrackingReport {
  bool begun = false;          ///< a scan was placed, by definition or by a match
  bool placed = false;         ///< the pose is one in the map
  int failures = 0;            ///< scans in a row that were not matched
  int points = 0;              ///< of the newest scan that was used
  int needed = 0;              ///< that a scan must have to say anything
  double range_noise = 0.0;    ///< [m] standard deviation of ranges that are too noisy to be used; 0: they are used
  double contradiction = 0.0;  ///< [m] between the ways that scans and odometry tell; 0: noise explains it
  double scan_drift = 0.0;     ///< [rad/s] of the scans' heading by a gyro that was right at rest; 0: none is certain
};

/// Where a FrontEnd begins.
struct FrontEndStart {
  std::int32_t map_id = 0;    ///< written into the keyframes; a new one is a new map
  int first_keyframe = 0;     ///< id of its first keyframe: a stored map has so many
  bool in_known_map = false;  ///< the map has content: the robot must be found in it
  Pose2 T_map_base = {};      ///< last pose known
  BodyShape body = {};        ///< what moves with the robot, as last known
  double gyro_bias = 0.0;     ///< [rad/s] last value known
};

}  // namespace slam
