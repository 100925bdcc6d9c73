// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/estimates.hpp"
#include "core/keyframe.hpp"
#include "core/pseudo_laser.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "core/timestamp.hpp"
#include "estimation/ekf_timeline.hpp"
#include "estimation/odometry_monitor.hpp"
#include "frontend/depth_view_selector.hpp"
#include "frontend/front_end_config.hpp"
#include "frontend/intake/sensor_intake.hpp"
#include "frontend/keyframe_selector.hpp"
#include "frontend/local_map.hpp"
#include "frontend/map_correction.hpp"
#include "frontend/match_validator.hpp"
#include "frontend/preprocessor.hpp"
#include "frontend/registration.hpp"
#include "frontend/tracking_state.hpp"

namespace slam {

/// What one scan did.
struct ScanOutcome {
  Timestamp stamp;     ///< of the middle of the turn in the filter's time: the pose is right there
  Timestamp first;     ///< of the first beam, which is the scan's own stamp, in the filter's time
  Pose2 T_base_first;  ///< base at `first`, seen from base at `stamp`
  MatchResult match;
  Duration match_time{0};              ///< spent in the matcher; 0 without a stopwatch
  bool fused = false;                  ///< the match passed the filter's gate
  const LaserScan* scan = nullptr;     ///< as it was interpreted; valid until the next one, and as long as it
  bool stuck = false;                  ///< the lidar repeats a turn although the robot moves: the scan was not used
  bool misdated = false;               ///< its stamp is no moment of this drive: the scan was not used
  const Keyframe* keyframe = nullptr;  ///< set when the scan became one, or a refresh; valid until the next scan
};

/// The paper's pipeline from sensors to pose.
///
/// Two filters run over the same wheels and IMU: the odometry filter never sees the lidar and drifts smoothly in odom;
/// the pose filter also fuses matched scans and lives in map. T_map_odom joins them.
///
/// No thread, clock or I/O; after construction no allocation. Not safe for concurrent use.
class FrontEnd {
 public:
  explicit FrontEnd(const FrontEndConfig& config, Stopwatch stopwatch = nullptr, const FrontEndStart& start = {});

  /// Takes the memory of its map from the system now instead of at its first use.
  void takeMemory() { local_map_.takeMemory(); }

  void add(const WheelSample& sample);
  void add(const ImuSample& sample);
  /// @param may_keep false: the scan becomes no keyframe, because nobody could take it
  ScanOutcome add(const LaserScan& scan, bool may_keep = true);

  /// @return where a depth image was seen from, if it is to be drawn; valid until the next call
  const DepthObservation* add(const PseudoLaser& laser);

  /// Pose of base in map at `stamp`, predicted from the newest samples.
  PoseEstimate estimate(Timestamp stamp) const;
  OdometryEstimate odometry(Timestamp stamp) const;

  /// Moves the robot in the map, by command: a session begins there, which the back end compares with the map.
  /// @param sigma [m, m, rad]
  void setPose(const Pose2& T_map_base, const Eigen::Vector3d& sigma);

  /// Goes on in the map as the back end has corrected it: pose and reference change together, see LocalMap::apply(). A
  /// correction that refutes a given pose says that the robot is lost, one made for another session changes nothing;
  /// the old reference is left in it, to be recycled outside the pose path.
  void apply(MapCorrection& correction);

  AnchoredPose anchor(const Pose2& T_map_base) const { return local_map_.anchor(T_map_base); }
  /// The keyframes that scans are matched against, by id.
  std::span<const ReferenceKeyframe> referenceKeyframes() const { return local_map_.keyframes(); }

  std::int32_t mapId() const { return keyframes_.mapId(); }
  Timestamp newestStamp() const { return pose_.newestStamp(); }
  /// Counts up when the robot is lost, or its pose given by a person.
  std::int32_t session() const { return keyframes_.session(); }
  /// false: the pose is relative to the session's beginning, not to the map
  bool placed() const { return tracking_.placed(); }

  TrackingReport trackingReport(Timestamp stamp) const;

  const FrontEndConfig& config() const { return config_; }
  FrontEndCounters counters() const;
  const WheelScale& wheelScale() const { return monitor_.wheels.scale(); }
  /// By how much the lidar's mount is off, as the whole drive tells it.
  const MountError& mountError() const { return monitor_.mount.error(); }
  /// By how much the lidar's stamps are off, as the gyro shows it.
  const LidarDelay& lidarDelay() const { return monitor_.delay; }
  /// The wheels report that they stand, while scans show that the robot moves.
  bool wheelsDead() const { return pose_.newest().wheelsDead(); }
  GyroVerdict gyroVerdict() const { return monitor_.gyro.verdict(gyroBias()); }
  /// What was found out about the lidar's beams.
  const ScanInterpreter& interpreter() const { return preprocessor_.interpreter(); }
  EkfCounters filterCounters() const { return pose_.newest().counters(); }

 private:
  ScanOutcome track(const LaserScan& recorded, bool may_keep);
  const Keyframe* beginMap(const Cloud& cloud, const Prediction& predicted);
  void recoverBySearch(const Cloud& cloud, const Prediction& predicted, ScanOutcome& outcome);
  const Keyframe* follow(const Cloud& cloud, const Prediction& predicted, const MatchResult& match, bool may_keep);
  const Keyframe* coast(const Cloud& cloud, const Prediction& predicted, const MatchResult& match, bool may_keep);
  double gyroBias() const { return pose_.newest().gyroBias(); }
  void correctGyroBias(const GyroBias& bias);
  void compareTurns(Timestamp stamp, const MatchResult& match, bool stamped);
  void endDoubt();
  void shareGyroBias();
  bool isInformative(const Cloud& cloud) const;
  bool fuse(const Cloud& cloud, const Prediction& predicted, const MatchResult& match, bool bypass_gate);
  void leaveFarPlace();
  void leaveTheFloor(Timestamp stamp);
  void beginSession(KeyframeOrigin origin);

  FrontEndConfig config_;
  EkfTimeline odometry_, pose_;
  SensorIntake intake_;
  OdometryMonitor monitor_;
  Preprocessor preprocessor_;
  LocalMap local_map_;
  Registration registration_;
  MatchValidator validator_;
  TrackingState tracking_;
  KeyframeSelector keyframes_;
  DepthViewSelector views_;
  std::uint32_t far_off_ = 0;
  bool lifted_ = false;   // by its wheels, which hang in the air
  bool carried_ = false;  // lifted, and no scan has been fused since: its place is not valid
};

}  // namespace slam
