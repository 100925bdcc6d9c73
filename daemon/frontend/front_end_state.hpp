// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/counter_info.hpp"
#include "core/keyframe.hpp"
#include "core/pose2.hpp"

namespace slam {

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
  bool assumed = false;        ///< ... if the robot has not taken a lift to where another map begins
  bool silent = false;         ///< no sensor tells the motion: wheels, gyro and scans are away
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
