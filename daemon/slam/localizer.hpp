// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/estimates.hpp"
#include "core/keyframe.hpp"
#include "core/pose_history.hpp"
#include "core/pseudo_laser.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "estimation/ekf_timeline.hpp"
#include "matching/correlative.hpp"
#include "matching/deskew.hpp"
#include "matching/match_result.hpp"
#include "matching/normals.hpp"
#include "matching/range_image.hpp"
#include "matching/reference.hpp"
#include "slam/map_correction.hpp"
#include "slam/pull_watch.hpp"
#include "slam/scan_repeat_watch.hpp"
#include "slam/stamp_sequencer.hpp"
#include "slam/wheel_trust.hpp"

namespace slam {

/// Extrinsics of the lidar and what its readings are worth.
struct LidarModel {
  Pose2 T_base_lidar;
  bool upside_down = false;    ///< its bearings grow clockwise, seen from above
  double range_min = 0.15;     ///< [m] shorter returns are not obstacles
  double range_max = 12.0;     ///< [m] longer returns are not trusted
  double range_sigma = 0.015;  ///< [m] standard deviation of one range
  double time_offset = 0.0;    ///< [s] added to the lidar's stamps

  LidarMounting mounting() const { return {T_base_lidar, upside_down}; }
};

/// When a scan is kept for reference and map.
struct KeyframeConfig {
  double translation = 0.20;  ///< [m] since the last keyframe
  double rotation = 0.17;     ///< [rad] since the last keyframe
  double familiarity = 0.80;  ///< [1] a scan that shows this share of well-known surfels adds nothing: it is a look
  double look_period = 1.0;   ///< [s] between looks of a robot that stands still in a known place
  double overlap = 0.70;      ///< [1] share of points that meet the reference: fewer makes a keyframe soon
  int max_failures = 8;       ///< scans in a row without a match, and `degraded_after`: then one is kept as predicted
};

/// How the pose drifts from keyframe to keyframe while scans are matched; a random walk of strength q has standard
/// deviation q * sqrt(distance). Without matches, and along blind directions, the wheels' noise counts instead.
struct DriftConfig {
  double translation = 0.01;           ///< [m per sqrt(m)]
  double rotation_per_metre = 0.001;   ///< [rad per sqrt(m)]
  double rotation_per_radian = 0.003;  ///< [rad per sqrt(rad)]
};

/// When what the depth camera sees is drawn. Views from one place have the same errors: many of them prove no more than
/// one, but they show what has changed there.
struct DepthViewConfig {
  double time_offset = 0.0;   ///< [s] added to the camera's stamps
  double translation = 0.05;  ///< [m] since the last view
  double rotation = 0.05;     ///< [rad] since the last view
  double period = 0.2;        ///< [s] since the last view
};

struct LocalizerConfig {
  LidarModel lidar;
  double wheel_time_offset = 0.0, imu_time_offset = 0.0;  ///< [s] added to the stamps
  DepthViewConfig depth;
  EkfConfig ekf;
  EkfTimelineConfig timeline;
  NormalConfig normals;
  ReferenceConfig reference;
  MatchConfig match;
  CorrelativeConfig search;
  SearchWindow search_window;  ///< around the prediction, after a failed match; grows with each further failure
  WheelTrustConfig wheel_trust;
  PullWatchConfig pull_watch;
  double max_doubt = 3.0;  ///< [1] Ekf::doubt() above which a prediction is one guess among others
  KeyframeConfig keyframe;
  DriftConfig drift;
  bool localise_only = false;        ///< the map is given: scans do not extend it
  double kidnap_distance = 1.0;      ///< [m] a robot that was localised this near cannot have left the known map: when
  double kidnap_rotation = 1.5;      ///< [rad] its scans match no longer, it was carried away
  double degraded_after = 1.0;       ///< [s] without a matched scan
  double lost_position_sigma = 1.0;  ///< [m] a position this uncertain is not valid
};

struct LocalizerCounters {
  std::uint32_t scans = 0, matched = 0, partly_observable = 0, unmatched = 0, gated = 0, keyframes = 0;
  std::uint32_t lost = 0;              ///< times that the place in the map was lost, or given by a person
  std::uint32_t searched = 0;          ///< scans whose prediction led to no match and that were searched for
  std::uint32_t scans_held = 0;        ///< matches that something moving pulled, which were held to the wheels' way
  std::uint32_t scans_too_late = 0;    ///< older than the filter's window
  std::uint32_t scans_repeated = 0;    ///< copies of the scan before them, which were not used
  std::uint32_t scans_retimed = 0;     ///< stamp not after its predecessor's
  std::uint32_t clock_resets = 0;      ///< stamps jumped back by seconds
  std::uint32_t samples_late = 0;      ///< wheel and IMU samples fused at their place behind newer ones
  std::uint32_t samples_too_old = 0;   ///< wheel and IMU samples dropped
  std::uint32_t wheels_withdrawn = 0;  ///< times that the wheels contradicted the scans too much to be heard
  bool wheels_heard = true;            ///< now
  double wheels_scale = 1.0;           ///< [1] what their way is divided by, as the scans have shown so far
  std::uint32_t far_ahead = 0;         ///< samples dropped whose stamp alone was seconds ahead
  std::uint32_t views = 0;             ///< depth images drawn
  std::uint32_t views_unplaced = 0;    ///< depth images dropped because the pose at their stamp was not valid or known
};

/// What one scan did.
struct ScanOutcome {
  Timestamp stamp;     ///< of the middle of the turn in the filter's time: the pose is right there
  Timestamp first;     ///< of the first beam, which is the scan's own stamp, in the filter's time
  Pose2 T_base_first;  ///< base at `first`, seen from base at `stamp`
  MatchResult match;
  Duration match_time{0};              ///< spent in the matcher; 0 without a stopwatch
  bool fused = false;                  ///< the match passed the filter's gate
  bool stuck = false;                  ///< the lidar repeats a turn although the robot moves: the scan was not used
  const Keyframe* keyframe = nullptr;  ///< set when the scan became one, or a look; valid until the next scan
};

/// Where a Localizer begins.
struct LocalizerStart {
  std::int32_t map_id = 0;    ///< written into the keyframes; a new one is a new map
  int first_keyframe = 0;     ///< id of its first keyframe: a stored map has so many
  bool in_known_map = false;  ///< the map has content: the robot must be found in it
  Pose2 T_map_base = {};      ///< last pose known
  double gyro_bias = 0.0;     ///< [rad/s] last value known
};

/// Whether a robot moves so fast that no sensor sees the same twice.
bool isMoving(const Twist2& twist);

/// The front end: the paper's pipeline from sensors to pose.
///
/// Two filters run over the same wheels and IMU: the odometry filter never sees the lidar and drifts smoothly in odom;
/// the pose filter also fuses matched scans and lives in map. T_map_odom joins them.
///
/// No thread, clock or I/O; after construction no allocation. Not safe for concurrent use.
class Localizer {
 public:
  /// Newest keyframes that a correction need not know: their points are kept, so that they go on in the new reference.
  /// A back end in another thread must fall no further behind.
  static constexpr int kMostAhead = 65;

  /// Reads a clock for statistics only; given from outside, because this folder cannot read one.
  using Stopwatch = Timestamp (*)();

  explicit Localizer(const LocalizerConfig& config, Stopwatch stopwatch = nullptr, const LocalizerStart& start = {});

  void add(const WheelSample& sample);
  void add(const ImuSample& sample);
  /// @param may_keep false: the scan becomes no keyframe, because nobody could take it
  ScanOutcome add(const LaserScan& scan, bool may_keep = true);

  /// @return where a depth image was seen from, if it is to be drawn; valid until the next call
  const DepthSight* add(const PseudoLaser& laser);

  /// Pose of base in map at `stamp`, predicted from the newest samples.
  PoseEstimate estimate(Timestamp stamp) const;
  OdometryEstimate odometry(Timestamp stamp) const;

  /// Moves the robot in the map, by command: a segment begins there, which the back end compares with the map.
  /// @param sigma [m, m, rad]
  void setPose(const Pose2& T_map_base, const Eigen::Vector3d& sigma);

  /// Goes on in the map as the back end has corrected it: pose and reference change together, the pose rigidly by the
  /// motion of the keyframe nearest to the robot, or to where a lost robot was found. Keyframes newer than the
  /// correction stay, and move as the newest one does that it knows. One that refutes a given pose says that the robot
  /// is lost, one made for another segment changes nothing. @return the old reference, to be recycled outside the pose
  /// path
  void apply(MapCorrection& correction);

  /// The keyframe nearest to a pose, and the pose relative to it.
  struct Anchored {
    int keyframe = -1;  ///< -1: there is none yet, and the pose is that in map
    Pose2 T_keyframe_base;
  };
  Anchored anchor(const Pose2& T_map_base) const;
  /// The keyframes that scans are matched against, by id.
  std::span<const ReferenceKeyframe> referenceKeyframes() const { return reference_keyframes_; }

  std::int32_t mapId() const { return start_.map_id; }
  Timestamp newestStamp() const { return pose_.newestStamp(); }
  /// Counts up when the robot is lost, or its pose given by a person.
  std::int32_t segment() const { return segment_; }
  /// false: the pose is relative to the segment's beginning, not to the map
  bool placed() const { return placed_; }

  const LocalizerConfig& config() const { return config_; }
  LocalizerCounters counters() const;
  const WheelScale& wheelScale() const { return wheel_trust_.scale(); }
  EkfCounters filterCounters() const { return pose_.at(pose_.newestStamp()).counters(); }

 private:
  MatchResult matchFromGuesses(Timestamp stamp, const Ekf& predicted) const;
  void holdIfPulled(Timestamp stamp, const Ekf& predicted, MatchResult& match);
  double supportOf(const MatchResult& match, const Pose2& guess);
  bool isTold(const Ekf& predicted, const MatchResult& match);
  bool isFind(const MatchResult& match);
  bool showsMore(const Pose2& T_map_base);
  void searchAround(const Pose2& predicted, ScanOutcome& outcome);
  void judgeWheels(const Ekf& odometry, const Pose2& T_map_base, const MatchResult& match);
  bool fuse(Timestamp stamp, const MatchResult& match, bool confirmed);
  LocalisationState state(Timestamp stamp, const Eigen::Matrix3d& covariance) const;
  const Keyframe* keepOrLook(Timestamp stamp, const Pose2& T_map_base, const MatchResult& match);
  const Keyframe* keep(Timestamp stamp, const Pose2& T_map_base, const MatchResult& match);
  const Keyframe* look(Timestamp stamp, const Pose2& T_map_base);
  bool carriedAway(const Pose2& predicted) const;
  void beginSegment(KeyframeOrigin origin);
  void accumulateDrift(const Pose2& T_map_base, const MatchResult* match);
  bool isCopy(const LaserScan& scan) const;
  void takePoints(const LaserScan& recorded, ScanOutcome& outcome);
  void describe(Timestamp stamp, const Pose2& T_map_base);

  LocalizerConfig config_;
  Stopwatch stopwatch_;
  LocalizerStart start_;
  EkfTimeline odometry_, pose_;
  ForwardJumpGuard wheel_guard_, imu_guard_, scan_guard_;
  StampSequencer wheel_stamps_, scan_stamps_;
  ScanRepeatWatch repeats_;
  bool stuck_ = false;
  Timestamp last_scan_, last_first_;  // as recorded, and in the filter's time
  ClockStepBridge imu_clock_;
  Reference reference_;
  std::vector<ReferenceKeyframe> reference_keyframes_;  // by id
  struct KeptScan {
    int id = -1;
    std::vector<Keyframe::Point> points;
  };
  std::array<KeptScan, kMostAhead> kept_;  // newest keyframes, which a correction may not know yet
  ScanPoints newest_points_;               // of the newest keyframe, while there is a last_keyframe_
  CorrelativeMatcher search_;
  RangeImage image_;
  PoseHistory history_;
  ScanPoints points_;
  MatchConfig match_;  // for them
  DepthSight sight_;
  std::optional<Pose2> last_view_;  // in odom
  Timestamp last_view_stamp_;
  Keyframe keyframe_;
  std::optional<Pose2> last_keyframe_;
  Pose2 last_look_;
  Timestamp last_look_stamp_;
  std::optional<Timestamp> last_match_;
  Pose2 drift_pose_;
  Eigen::Matrix3d drift_ = Eigen::Matrix3d::Zero();  // in map, since the last keyframe
  Pose2 last_pose_, last_motion_;                    // at the last matched scan, and from the one before
  Pose2 last_odometry_;                              // in odom, at the last matched scan
  bool has_wheels_ = false;
  WheelTrust wheel_trust_;
  RescaledWheels rescaled_wheels_;
  PullWatch pull_watch_;
  bool wheels_held_back_ = false;  // the newest sample was not given to the pose filter
  std::int32_t segment_ = 0;
  KeyframeOrigin origin_ = KeyframeOrigin::kContinued;  // of the next keyframe
  bool placed_ = true, was_placed_ = false;
  bool extends_ = true;  // the reference, by keyframes
  int next_keyframe_ = 0;
  double overlap_ = 0.0, fused_overlap_ = 0.0;  // of the last match, and of the last one that was fused
  int failures_ = 0;
  LocalizerCounters counters_;
};

}  // namespace slam
