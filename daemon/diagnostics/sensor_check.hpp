// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>

#include "core/pose2.hpp"
#include "estimation/gyro_monitor.hpp"
#include "estimation/mount_monitor.hpp"
#include "estimation/wheel_scale.hpp"

namespace slam {

/// What is wrong with a sensor, its mounting or its recording, as far as the sensors' own samples can tell.
enum class SensorFault : std::uint8_t {
  kLidarUpsideDown,     ///< turns opposite to gyro and wheels
  kLidarAgainstGyro,    ///< turns opposite to the gyro, and no wheels decide who is right
  kLidarAgainstWheels,  ///< turns opposite to the wheels, and no gyro decides who is right
  kGyroReversed,        ///< the gyro turns opposite to lidar and wheels
  kWheelsSwapped,       ///< the wheels turn opposite to lidar and gyro
  kWheelsBackwards,     ///< the wheels turn and drive opposite to the lidar
  kLidarYawOff,         ///< the lidar travels in another direction than the wheels; value: [rad] to add to its yaw
  kWheelDistanceOff,    ///< value: the wheels' distance / the lidar's
  kWheelTurnOff,        ///< value: the wheels' turn / the lidar's
  kWheelsContradict,    ///< wheels and lidar do not move together at all
  kScansRepeated,       ///< value: scans that repeat the one before them
  kTimeBackwards,       ///< value: scans stamped before their predecessor
  kLidarMountOff,       ///< lidar and wheels turn about other centres; values: [m] to add to the lidar's x and y
  kGyroDegrees,         ///< value: the gyro's turn / that of lidar and wheels, which looks like deg/s for rad/s
  kGyroTurnOff,         ///< value: the gyro's turn / that of lidar and wheels
  kGyroOffset,          ///< value: [rad/s] that the gyro reads at rest, taken off its readings
  kGyroFarOff,          ///< value: [rad/s] the same, so much that the gyro is not used
  kGyroClipped,         ///< value: [rad/s] that the gyro reads at most
  kGyroContradicts,     ///< the gyro does not turn with lidar and wheels at all
  kMovesWithRobot,      ///< the lidar sees the robot itself, or what it tows; values: [deg] of the turn, their middle
  kNoReturnCodes,       ///< a range is written where nothing came back; values: [m] the largest, how many there are
  kRangesScatter,       ///< value: [m] standard deviation of the ranges at rest, too much to match scans
  kBeamTimesMissing,    ///< beams carry no times, and the robot turns while they are measured
  kStampsAlone,         ///< value: samples stamped far ahead of all others, alone
  kWheelsDead,          ///< the wheels report that they stand, while scans show that the robot moves
  kLidarDelay,          ///< values: [s] to add to the lidar's stamps, which slamd does, and its standard deviation
};
constexpr std::size_t kSensorFaults = 26;

struct SensorFinding {
  SensorFault fault = SensorFault::kLidarUpsideDown;
  double value = 0.0, second = 0.0;  ///< as the fault says
};

struct SensorFindings {
  std::array<SensorFinding, kSensorFaults> storage{};
  std::size_t size = 0;

  void add(SensorFault fault, double value = 0.0, double second = 0.0) { storage[size++] = {fault, value, second}; }
  std::span<const SensorFinding> all() const& { return {storage.data(), size}; }
  std::span<const SensorFinding> all() const&& = delete;  // it would outlive them
};

struct SensorCheckConfig {
  static constexpr double kDegree = std::numbers::pi / 180.0;

  double least_turn = 0.06;               ///< [rad] smaller motions are noise
  double least_travel = 0.06;             ///< [m]
  double straight = 0.20;                 ///< [rad] a bend hides the direction of travel
  int least_alike = 5;                    ///< pairs that agree with each other before anything is said ...
  int wanted = 25;                        ///< pairs of turns and of travel to gather soon
  int many_pairs = 40;                    ///< before "no relation at all" is said
  double usual = 0.25;                    ///< [1] share of all pairs that show a motion which is no slip
  double most = 0.60;                     ///< [1] share of the angles near the peak
  double same_size = 12.0 * kDegree;      ///< [rad] about 45 degrees: 0.65 to 1.54 of each other
  double nearly_same = 4.5 * kDegree;     ///< [rad] of distances, where many pairs tell them: 0.85 to 1.17
  double known_scale = 0.02;              ///< [1] standard deviation of the whole way's scale ...
  double off_scale = 0.05;                ///< [1] ... and its error
  double off_yaw = 1.0 * kDegree;         ///< [rad] of the mount, and ...
  double off_offset = 0.02;               ///< [m] ... less does little harm
  double sure = 4.0;                      ///< [1] standard deviations of it that are no chance
  double both_move = 10.0 * kDegree;      ///< [rad] from 0 and 90 degrees: there only one of them moves
  double yaw_tolerance = 30.0 * kDegree;  ///< [rad]
  int few_degrees = 8;  ///< [deg] of what moves with the robot: fewer do no harm, and a wall may look so for a while
  double clock_step = 1.0;        ///< [s] back by more is a clock that was set
  int least_count = 5;            ///< of repeated or misdated scans ...
  double repeated_share = 0.01;   ///< [1] ... and their share of all
  double backwards_share = 0.10;  ///< [1] many recordings hold a few, by tenths of a second; they do no harm
};

/// The findings with what matched scans and wheels show of the gyro: it is assessed there turn by turn.
SensorFindings withGyro(const SensorFindings& findings, const GyroVerdict& gyro);

/// The findings with the wheels' distances assessed by the whole way that was matched, once it shows them: pairs of
/// scans that have no part in each other's neighbours take a corridor for a shorter way.
SensorFindings withDistances(const SensorFindings& findings, const WheelScale& scale,
                             const SensorCheckConfig& config = {});

/// The findings with where the lidar sits, as the ways of the whole drive show it. A lidar or wheels that are reversed
/// explain it, too.
SensorFindings withMount(const SensorFindings& findings, const MountError& mount, const SensorCheckConfig& config = {});

/// The motion of base between two scans, by each sensor alone.
struct MotionEvidence {
  Pose2 scans;                                ///< by matching one scan against the other, without a guess from others
  bool turn_seen = true, travel_seen = true;  ///< what of it the scans could see
  std::optional<Pose2> wheels = {};
  bool wheels_turn_known = true;         ///< false: their theta says nothing
  std::optional<double> gyro_turn = {};  ///< [rad]
  double seconds = 0.0;                  ///< [s] between the two; 0: not known
};

/// How angles are spread over a circle: where most of them are, and how many. Adding costs one count.
class AngleCounts {
 public:
  explicit AngleCounts(double period) : period_(period) {}
  void add(double angle);

  struct Peak {
    double angle = 0.0;  ///< in [-period/2, period/2)
    double share = 0.0;  ///< [1] of all angles that lie near it
  };
  Peak peak() const;
  /// @return how many lie between two angles of [-period/2, period/2], give or take a bin
  int between(double low, double high) const;
  int count() const { return count_; }

 private:
  static constexpr int kBins = 72, kReach = 4;  // bins on either side of the peak's that belong to it
  double period_;
  std::array<std::int32_t, kBins> bins_{};
  int count_ = 0;
};

/// Collects evidence of sensors that contradict each other and says what is wrong once most of it agrees.
///
/// Each pair of a motion by scans and the same by another sensor gives an angle atan2(scans, other): 45 degrees where
/// they agree, -45 where they are opposite, any other where one is out of scale. Where most angles are alike, that is
/// the finding; a few wrong matches, jumps or slips do not move it. The direction of travel gives the lidar's yaw,
/// the centre of turns its place.
///
/// No thread, clock or I/O, no allocation.
class SensorCheck {
 public:
  explicit SensorCheck(const SensorCheckConfig& config = {});
  void add(const MotionEvidence& evidence);
  /// @param repeated the scan before it once more
  /// @param back     [s] by how much it is stamped before the scan before it; 0 or less: it is not
  void addScan(bool repeated, double back);

  /// What the evidence says now, most of it taken together; empty as long as it is scarce or contradicts nothing.
  SensorFindings findings() const;
  /// @return whether there is little evidence yet of a robot's turns, or of its travel
  bool wants(bool turn) const;

 private:
  enum class Relation : std::uint8_t { kUnknown, kAgrees, kScaled, kOpposite, kUnrelated };
  /// @param same_size [rad] from 45 degrees: the two are of one scale
  Relation relation(const AngleCounts& angles, double same_size) const;
  void checkDirections(SensorFindings& findings) const;
  void checkWheels(SensorFindings& findings) const;

  SensorCheckConfig config_;
  AngleCounts gyro_turn_, wheel_turn_, wheel_distance_, wheel_direction_;
  int pairs_ = 0, scans_ = 0, repeated_ = 0, backwards_ = 0, clock_steps_ = 0;
};

}  // namespace slam
