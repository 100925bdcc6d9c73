// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "core/pose_history.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "diagnostics/sensor_check.hpp"
#include "frontend/front_end.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

struct MotionProbeConfig {
  double enough_travel = 0.10;                         ///< [m] that ends a pair of scans ...
  double enough_turn = 0.12;                           ///< [rad]
  Duration longest = std::chrono::seconds(1);          ///< ... as does the time ...
  Duration overdue = std::chrono::seconds(2);          ///< ... later it is given up
  Duration period = std::chrono::seconds(1);           ///< between pairs, while there is little evidence ...
  Duration long_period = std::chrono::seconds(30);     ///< ... and then
  Duration beyond = std::chrono::milliseconds(60);     ///< a history counts as reaching a scan so much later
  Duration gyro_gap = std::chrono::milliseconds(200);  ///< a gyro that was silent for longer has lost count
  Duration clock_step = std::chrono::seconds(1);       ///< back by more: the stream begins anew
  double small_turn = 0.03;                            ///< [rad] needs no guess
  double overlap = 0.75;                               ///< [1] of a pair that is believed
  double coarse = 1.5;                                 ///< [1] between so few beams a pair of scans can hide a travel
  double turn_in = 0.3;                                ///< [1] share of a degenerate direction that is a turn
  double still = 0.002, still_turn = 0.005;            ///< [m], [rad] between two scans, of a robot at rest
  int least_returns = 10;
};

/// Now and then measures how the robot moved between two scans by matching them with each other, and gives that with
/// what wheels and gyro say to a SensorCheck.
///
/// The match starts from no motion and from the turn that gyro or wheels claim, either way round, and takes what fits
/// best: it favours no sensor, so that it also works where the FrontEnd's prediction is opposite to what the lidar
/// sees. Pairs are matched one after the other only while they show what there is little evidence of, and then one in
/// half a minute.
///
/// No thread, clock or I/O; after construction no allocation. Not safe for concurrent use.
class MotionProbe {
 public:
  explicit MotionProbe(const FrontEndConfig& config, const MotionProbeConfig& probe = {});

  void add(const WheelSample& sample);
  void add(const ImuSample& sample);
  /// Cheap, also for a scan that is taken; the work on it is left to work(). @param delay of the lidar beyond the
  /// configured one
  void add(const LaserScan& scan, Duration delay = Duration(0));
  /// The scan as the front end has interpreted it, but none of a stuck lidar or of no moment of this drive: it is no
  /// measurement.
  void add(const ScanOutcome& outcome, Duration delay) {
    if (!outcome.stuck && !outcome.misdated) add(*outcome.scan, delay);
  }
  /// Matches the pair that add() has completed, some tenths of a millisecond; otherwise does nothing.
  void work();

  const SensorFindings& findings() const { return findings_; }

 private:
  enum class Stage : std::uint8_t {
    kIdle,     ///< no scan is held
    kBegun,    ///< the first one is, and waits for the robot to move on
    kEnded,    ///< both are, and wait for work()
    kMatched,  ///< waits for wheels and gyro to reach the second one
  };

  bool checkStream(const LaserScan& scan);
  void take(const LaserScan& scan, ScanPoints& points);
  void settle();
  std::optional<Pose2> wheelMotion(Timestamp from, Timestamp to, Duration extrapolation) const;
  std::optional<double> gyroTurn(Timestamp from, Timestamp to, Duration extrapolation) const;

  MotionProbeConfig config_;
  LidarModel lidar_;
  Duration wheel_offset_, imu_offset_;
  NormalConfig normals_;
  MatchConfig match_;
  PoseHistory wheels_, gyro_, at_rest_{2};  // the last stays empty: no sensor may shape the scans
  bool wheels_turn_known_ = true;
  Stage stage_ = Stage::kIdle;
  Timestamp first_, second_, newest_, next_, last_match_;
  double claimed_turn_ = 0.0;  // [rad] between the two
  ScanPoints first_points_, second_points_;
  Reference reference_;
  MotionEvidence evidence_;
  std::optional<Timestamp> last_scan_;
  Duration usual_step_{0};         // between the last two scans of which none repeats the other
  std::uint64_t last_ranges_ = 0;  // hash
  SensorCheck check_;
  SensorFindings findings_;
};

/// What is wrong with the sensors, as far as the probe and the front end know.
SensorFindings findingsOf(const MotionProbe& probe, const FrontEnd& front_end, const SensorCheckConfig& config = {});

}  // namespace slam
