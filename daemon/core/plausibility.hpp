// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstdint>
#include <string>

#include "core/samples.hpp"
#include "core/scan.hpp"

namespace slam {

/// What can be true of an indoor robot, its sensors and its maps. Every number from outside is held to these limits:
/// commands, messages, samples of devices, stored maps, floor plans. None is reached by a real robot, and within them
/// nothing that is computed overflows or takes memory without bound.
struct PlausibilityLimits {
  double farthest = 10e3;         ///< [m] from the map's origin: there a float, as surfels are, has steps of 1 mm
  double stored_farthest = 20e3;  ///< [m] of a keyframe, which closed loops may have moved beyond
  double turn = 6.3;              ///< [rad] of a heading: a full turn, rounded up; more was meant as degrees
  double dead_reckoned = 1e8;  ///< [m, rad] of wheels, whose origin is arbitrary: 3 years at 1 m/s, in steps of 15 nm
  double turn_rate = 200.0;    ///< [rad/s] gyros measure 70 at most
  double acceleration = 1e4;   ///< [m/s^2] 1000 g, more than any unit measures
  double mounting = 20.0;      ///< [m] of a sensor from its base
  float range = 1000.0F;       ///< [m] of a beam; no lidar sees that far indoors
  float depth_range = 100.0F;  ///< [m] of a depth camera
  float bearing = 100.0F;      ///< [rad] of a beam, which some lidars count up from turn to turn
  float scan_time = 10.0F;     ///< [s] of a beam from its scan's stamp: no lidar turns slower
  double information = 1e12;   ///< [1/m^2, 1/rad^2] of an edge: a sigma of 1 um
  double finest = 0.001, coarsest = 1.0;   ///< [m] side of a grid's cell: the noise of a lidar, the width of a door
  std::int64_t picture_cells = 1LL << 27;  ///< [cells] of a picture of a map: 580 m by 580 m at 5 cm
  std::int64_t text_bytes = 1 << 16;       ///< [bytes] of a text that describes a map, and of a picture's header
};
inline constexpr PlausibilityLimits kPlausible;

/// Whether an angle, a coordinate, ... lies within a limit to either side; NaN does not.
template <typename Number>
bool isWithin(Number value, Number limit) {
  return std::abs(value) <= limit;
}

/// Why this is no pose of a robot in a map, in words ("x = 1e+06 m lies ..."); empty: it is one.
/// @param farthest [m] from the map's origin along either axis
std::string implausibilityOf(const Pose2& T_map_base, double farthest = kPlausible.farthest);
inline bool isPlausible(const Pose2& T_map_base, double farthest = kPlausible.farthest) {
  return isWithin(T_map_base.x, farthest) && isWithin(T_map_base.y, farthest) &&
         isWithin(T_map_base.theta, kPlausible.turn);
}

/// Whether wheels can have dead-reckoned this pose.
inline bool isPlausible(const WheelSample& sample) {
  const Pose2& T = sample.T_wheels_base;
  return isWithin(T.x, kPlausible.dead_reckoned) && isWithin(T.y, kPlausible.dead_reckoned) &&
         isWithin(T.theta, kPlausible.dead_reckoned);
}

/// Whether an inertial unit can have measured this.
inline bool isPlausible(const ImuSample& sample) {
  return (sample.gyro.array().abs() <= kPlausible.turn_rate).all() &&
         (sample.accel.array().abs() <= kPlausible.acceleration).all();
}

/// The beam, or one without a return where a number of it cannot be.
inline Beam plausible(const Beam& beam) {
  if (!isWithin(beam.bearing, kPlausible.bearing) || !(std::abs(beam.time_offset) < kPlausible.scan_time)) return {};
  Beam sound = beam;
  if (!(beam.range >= 0.0F && beam.range <= kPlausible.range)) sound.range = 0.0F;
  return sound;
}

/// Why an occupancy grid cannot be as a picture of it says, in words; empty: it can.
/// @param resolution [m] side of a cell @param x, y [m] of its lower left corner in map
/// @param width, height [cells] of the picture
std::string implausibilityOfPicture(double resolution, double x, double y, std::int64_t width, std::int64_t height);
/// The same of a grid's resolution [m], and of a picture's size [cells], alone.
std::string implausibilityOfResolution(double resolution);
std::string implausibilityOfSize(std::int64_t width, std::int64_t height);

}  // namespace slam
