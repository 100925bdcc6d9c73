// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/replay.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <iostream>
#include <optional>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/received.hpp"
#include "diagnostics/sensor_problems.hpp"
#include "mapping/map_files.hpp"
#include "matching/deskew.hpp"
#include "runtime/process_usage.hpp"
#include "slam/pipeline.hpp"
#include "slam/refine/map_refinement.hpp"
#include "store/edit_files.hpp"
#include "store/map_store.hpp"
#include "tools/common/output_file.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/replay/estimates.hpp"
#include "tools/replay/viewer_frames.hpp"

namespace slam {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::uint32_t kFewMatched = 3;                // times as many scans that were not matched are too many
constexpr double kFewStuck = 5, kFewStuckShare = 0.01;  // scans of a stuck lidar, [1] of all: no more is no fault

double microsecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

Timestamp stopwatch() { return Timestamp(std::chrono::duration_cast<Duration>(Clock::now().time_since_epoch())); }

std::optional<TrajectoryWriter> writerFor(const std::filesystem::path& file) {
  return file.empty() ? std::nullopt : std::optional<TrajectoryWriter>(file);
}

bool drawsMap(const ReplayOptions& options) {
  return !options.map.empty() || !options.save_map.empty() || !options.viewer_frames.empty() || options.refine;
}

/// Lidar and gyro do not see the same turns, or one of them sees too few: their offset in time is none.
bool turnsDiffer(SensorFault fault) {
  switch (fault) {
    case SensorFault::kWheelsSwapped:
    case SensorFault::kWheelsBackwards:
    case SensorFault::kWheelDistanceOff:
    case SensorFault::kWheelTurnOff:
    case SensorFault::kGyroOffset:
    case SensorFault::kMovesWithRobot:
    case SensorFault::kNoReturnCodes:
    case SensorFault::kRangesScatter:
    case SensorFault::kBeamTimesMissing:
    case SensorFault::kStampsAlone:
    case SensorFault::kLidarDelay:
    case SensorFault::kWheelsDead:
      return false;
    default:
      return true;
  }
}

/// One run: the log's samples go through the pipeline, and what comes out into files.
class Run {
 public:
  Run(const Config& config, const ReplayOptions& options, const MapState& map)
      : use_lidar_(config.lidar_device.driver != LidarDriver::kNone),
        use_wheels_(config.base_device.driver != BaseDriver::kNone),
        use_imu_(config.imu_device.driver != ImuDriver::kNone),
        use_depth_(config.depth_device.driver != DepthDriver::kNone),
        localise_only_(config.mode == RunMode::kLocalise),
        pipeline_({frontEndConfig(config), backEndConfig(config), config.map, drawsMap(options)}, map, &stopwatch),
        final_(writerFor(options.trajectory)),
        causal_(writerFor(options.causal)),
        odometry_(writerFor(options.odometry)),
        wheels_(writerFor(options.wheels)) {
    if (!options.save_map.empty()) store_.emplace(options.save_map);
    if (!options.estimates.empty()) estimates_.emplace(options.estimates);
    if (!options.viewer_frames.empty()) viewer_.emplace(options.viewer_frames, options.viewer_period);
    pipeline_.on_scan = [this](const ScanOutcome& outcome) { write(outcome); };
    pipeline_.on_update = [this](const MapUpdate& update) { note(update); };
  }

  /// @param log_s [s] of the event since the log's begin
  void feed(const LogEvent& event, double log_s) {
    log_s_ = log_s;
    if (event.channel == channel::kScan && use_lidar_) {
      if (const auto scan = take<scan_t>(event, scans_)) {
        stats_.thinned_beams += static_cast<std::uint64_t>(thinnedBeams(*scan.message));
        addScan(*scan.sample, scan.message->utime);
      }
    } else if (event.channel == channel::kWheels && use_wheels_) {
      if (const auto wheels = take<wheels_t>(event, wheels_seen_)) addWheels(*wheels.sample, wheels.message->utime);
    } else if (event.channel == channel::kImu && use_imu_) {
      if (const auto imu = take<imu_t>(event, imus_)) pipeline_.add(*imu.sample);
    } else if (event.channel == channel::kDepth && use_depth_) {
      if (const auto depth = take<depth_t>(event, depths_)) pipeline_.add(*depth.sample);
    }
  }

  /// Whether the robot is being looked for in the map.
  bool lost() const { return !pipeline_.frontEnd().placed(); }

  /// How many scans were refused and why; empty: none.
  std::string refusedScans() const { return scans_.words(); }

  ReplayStats finish(const Config& config, const ReplayOptions& options) {
    std::optional<MapState> refined;  // where that made the map better
    if (options.refine) refined = refine(config);
    const KeyframeGraph& keyframes = refined ? refined->keyframes : pipeline_.backEnd().keyframes();
    for (const Row& row : poses_) {
      const Pose2 T_map_keyframe = row.keyframe < 0 ? Pose2{} : keyframes.pose(row.keyframe);
      if (final_) final_->write(row.utime, T_map_keyframe * row.T_keyframe_base);
    }
    for (auto* writer : {&final_, &causal_, &odometry_, &wheels_}) {
      if (*writer) (*writer)->close();
    }
    if (estimates_) estimates_->close();
    if (!options.map.empty()) writeMap(options.map, config.map, refined);
    if (!options.save_map.empty()) saveMap(refined ? std::move(*refined) : pipeline_.state());
    stats_.front_end = pipeline_.frontEnd().counters();
    stats_.filter = pipeline_.frontEnd().filterCounters();
    stats_.back_end = pipeline_.backEnd().counters();
    stats_.lidar_gyro_offset = pipeline_.frontEnd().lidarDelay().estimate();
    for (const RefusedMessages* refused : {&scans_, &wheels_seen_, &imus_, &depths_})
      if (const std::string words = refused->words(); !words.empty()) stats_.refusals.push_back(words);
    bool explained = false;
    const SensorFindings findings = pipeline_.findings();
    for (const SensorFinding& finding : findings.all()) {
      stats_.warnings.push_back(problemOf(finding).words());
      stats_.turns_differ |= turnsDiffer(finding.fault);
      explained |= finding.fault != SensorFault::kScansRepeated && finding.fault != SensorFault::kTimeBackwards &&
                   finding.fault != SensorFault::kStampsAlone;
    }
    if (stats_.wheels_died && !pipeline_.frontEnd().wheelsDead())
      stats_.warnings.push_back(Problem(problem::kWheelsDead).words());
    if (scans_stuck_ > std::max(kFewStuck, kFewStuckShare * stats_.front_end.scans)) {
      stats_.warnings.push_back(
          "the lidar was stuck: " + std::to_string(scans_stuck_) +
          " scans show the ranges of the turn before although the robot moves; they were left out; "
          "look after its cable and power");
    }
    if (scans_blind_ > 0)
      stats_.warnings.push_back("lidar: " + std::to_string(scans_blind_) + " scans with " +
                                problemOf(echo_finding_).words());
    if (const auto times = stats_.front_end.wheels_rejected; times > 0 && !explained) {
      stats_.warnings.push_back("the wheels contradicted the scans and were not heard, " + std::to_string(times) +
                                " times: do they slip, lag behind, or have a wrong radius or sign?");
    }
    const auto matched = stats_.front_end.matched + stats_.front_end.partly_observable;
    const bool named = matched > 0 && explained && stats_.turns_differ;  // the cause is
    if (const auto scans = stats_.front_end.scans;
        scans > 0 && !named && stats_.notMatched() >= kFewMatched * matched) {
      stats_.warnings.push_back(
          (matched == 0 ? "no scan" : "only " + std::to_string(matched) + " of " + std::to_string(scans) + " scans") +
          std::string(matched == 1 || matched == 0 ? " was" : " were") +
          " matched; poses and map are not to be trusted; are the ranges finite and between "
          "range_min and range_max, the beams' bearings right, and the stamps near those of "
          "wheels and IMU?");
    }
    if (viewer_) {
      drawFrame();
      viewer_->close();
    }
    return std::move(stats_);
  }

 private:
  template <typename Message>
  Received<Message> take(const LogEvent& event, RefusedMessages& refused) {
    Received<Message> received(event.data);
    refused.count(received.refusal);
    stats_.rejected_messages += received.refusal != Refusal::kNone;
    return received;
  }

  void addWheels(const WheelSample& sample, std::int64_t utime) {
    pipeline_.add(sample);
    if (wheels_) wheels_->write(utime, sample.T_wheels_base);
  }

  void addScan(const LaserScan& scan, std::int64_t utime) {
    utime_ = utime;
    const LidarModel& lidar = pipeline_.frontEnd().config().lidar;
    echoes_.add(scan, {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)}, scan.stamp);
    if (echoes_.finding() != EchoWatch::Finding::kNone) echo_finding_ = echoes_.finding();
    scans_blind_ += echoes_.finding() != EchoWatch::Finding::kNone;
    begin_ = Clock::now();
    const ScanOutcome outcome = pipeline_.add(scan);
    if (!viewer_) return;
    see(scan, outcome.first);
    if (viewer_->due(log_s_)) drawFrame();
  }

  void write(const ScanOutcome& outcome) {
    if (outcome.misdated) return;  // nobody knows of which moment its pose is
    const FrontEnd& front_end = pipeline_.frontEnd();
    const ScanEstimate known = estimateOf(front_end, outcome, utime_);
    stats_.scan_us.push_back(microsecondsSince(begin_));
    scans_stuck_ += outcome.stuck;
    stats_.wheels_died |= pipeline_.frontEnd().wheelsDead();
    if (outcome.match.iterations > 0) stats_.match_us.push_back(1e6 * toSeconds(outcome.match_time));
    // Before a correction moves the keyframes; in a given map, whose keyframes stay, the pose is its own anchor.
    const AnchoredPose pose = localise_only_ ? AnchoredPose{-1, known.T_map_base} : front_end.anchor(known.T_map_base);
    poses_.push_back({utime_, front_end.session(), pose.keyframe, pose.T_keyframe_base});
    if (causal_) causal_->write(utime_, known.T_map_base);
    if (odometry_) odometry_->write(utime_, known.T_odom_base);
    if (estimates_) estimates_->write(known);
  }

  void note(const MapUpdate& update) {
    if (!update.poses.empty()) stats_.optimise_ms.push_back(1e3 * toSeconds(update.work));
    if (localise_only_ && update.correction && update.correction->T_map_session)
      placeRows(*update.correction->T_map_session);
  }

  /// Keeps the scan for the next frame.
  void see(const LaserScan& scan, Timestamp stamp) {
    const LidarModel& lidar = pipeline_.frontEnd().config().lidar;
    PoseHistory motion(2);
    const Timestamp end = stamp + (scan.size > 0 ? fromSeconds(scan.beams().back().time_offset) : Duration(0));
    for (const Timestamp t : {stamp, end}) motion.push(t, pipeline_.frontEnd().odometry(t).T_odom_base);
    deskew(scan, {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)}, stamp, lidar.mounting(),
           motion, points_);
    seen_.clear();
    for (const ScanPoint& point : points_) seen_.push_back(point.position);
    seen_stamp_ = stamp;
  }

  void drawFrame() {
    const PoseGraph& graph = pipeline_.backEnd().keyframes().graph();
    viewer_->write(renderMap(pipeline_.drawn().grid()),
                   {.log_s = log_s_,
                    .T_map_base = pipeline_.frontEnd().estimate(seen_stamp_).T_map_base,
                    .scan = seen_,
                    .keyframes = graph.poses(),
                    .edges = graph.edges()});
  }

  std::optional<MapState> refine(const Config& config) {
    RefinedMap refined = refineMap(pipeline_.state(), backEndConfig(config), config.map);
    stats_.refinement = refined.report;
    return std::move(refined.map);
  }

  void writeMap(const std::filesystem::path& prefix, const OccupancyGridConfig& grid,
                const std::optional<MapState>& refined) {
    Mapper again(grid);
    if (refined)
      again.load(scansOf(*refined), viewsOf(*refined), refined->grid.clone(), refined->grid_keyframes,
                 drawingOf(*refined));
    const Mapper& mapper = refined ? again : pipeline_.drawn();
    const MapImage image = renderMap(mapper.grid());
    writeMapFiles(prefix, image, mapper.path());
    if (pipeline_.backEnd().map().edits.empty()) return;
    refined ? writeEditFiles(prefix, *refined, image) : writeEditFiles(prefix, pipeline_.state(), image);
  }

  void saveMap(MapState map) {
    map.utime = poses_.empty() ? 0 : poses_.back().utime;
    store_->store.checkpoint(map);
  }

  /// The session was found: where the robot was since it got lost is known now.
  void placeRows(const Pose2& T_map_session) {
    for (auto row = poses_.rbegin(); row != poses_.rend() && row->session == pipeline_.frontEnd().session(); ++row) {
      row->T_keyframe_base = T_map_session * row->T_keyframe_base;
    }
  }

  /// Where the map will be stored: nobody else's from the begin.
  struct Destination {
    explicit Destination(const std::filesystem::path& path)
        : folder(std::filesystem::absolute(path).lexically_normal()),
          store(folder.parent_path(), folder.filename()),
          lock(folder) {}
    std::filesystem::path folder;
    MapStore store;
    FolderLock lock;
  };

  struct Row {
    std::int64_t utime;
    std::int32_t session;
    std::int32_t keyframe;  // -1: the pose is that in map
    Pose2 T_keyframe_base;
  };

  bool use_lidar_, use_wheels_, use_imu_, use_depth_;  // a driver of "none" is left out of the log, too
  bool localise_only_;
  RefusedMessages scans_{channel::kScan}, wheels_seen_{channel::kWheels}, imus_{channel::kImu},
      depths_{channel::kDepth};
  Pipeline pipeline_;
  std::optional<TrajectoryWriter> final_, causal_, odometry_, wheels_;
  std::optional<EstimateWriter> estimates_;
  std::optional<Destination> store_;
  int scans_stuck_ = 0, scans_blind_ = 0;
  EchoWatch echoes_;
  EchoWatch::Finding echo_finding_ = EchoWatch::Finding::kNone;
  std::deque<Row> poses_;
  std::int64_t utime_ = 0;   // [us] of the scan being used ...
  Clock::time_point begin_;  // ... and when that began
  std::optional<ViewerFrames> viewer_;
  double log_s_ = 0.0;
  ScanPoints points_;
  std::vector<Eigen::Vector2d> seen_;  // points of the newest scan in base
  Timestamp seen_stamp_;
  ReplayStats stats_;
};

MapState loadMap(const Config& config, const std::filesystem::path& path) {
  LoadedMap loaded = openMap(path, config.map);
  for (const std::string& remark : loaded.remarks) std::cerr << "slam-replay: " << remark << "\n";
  const std::string misfit = misfitOf(loaded.state, config.front_end.lidar, config.mode == RunMode::kLocalise);
  if (!misfit.empty()) throw std::runtime_error(path.string() + ": " + misfit);
  return std::move(loaded.state);
}

}  // namespace

std::optional<config_t> configOf(const std::vector<std::filesystem::path>& logs) {
  EventLogSequence log(logs);
  LogEvent event;
  return log.next(event) && event.channel == channel::kConfig ? decodeChecked<config_t>(event.data) : std::nullopt;
}

ReplayStats replay(const Config& config, const ReplayOptions& options,
                   const std::function<void(double log_seconds, bool lost)>& progress) {
  const auto start = Clock::now();
  const double cpu_before = cpuSeconds();
  for (const auto& file : {options.trajectory, options.causal, options.estimates, options.odometry, options.wheels}) {
    prepareOutput(file);
  }
  prepareMapFiles(options.map);
  EventLogSequence log(options.logs);
  if (options.load_map.empty() && config.mode == RunMode::kLocalise)
    throw std::runtime_error("mode \"localise\" needs a map; give --load-map");
  Run run(config, options, options.load_map.empty() ? MapState() : loadMap(config, options.load_map));
  std::int64_t first = 0, last = 0;
  for (LogEvent event; log.next(event);) {
    if (first == 0) first = event.utime;
    last = std::max(last, event.utime);
    const double log_s = 1e-6 * static_cast<double>(last - first);
    run.feed(event, log_s);
    if (progress) progress(log_s, run.lost());
  }
  ReplayStats stats = run.finish(config, options);
  if (stats.front_end.scans == 0) {
    const std::string refused = run.refusedScans(), log_name = options.logs.front().string() + ": ";
    throw std::runtime_error(log_name + (!refused.empty()
                                             ? "no scan in it can be used: " + refused
                                             : "no SLAM_SCAN in it; slam-convert makes logs for slam-replay"));
  }
  stats.log_s = 1e-6 * static_cast<double>(last - first);
  stats.wall_s = 1e-6 * microsecondsSince(start);
  stats.cpu_s = cpuSeconds() - cpu_before;
  stats.peak_rss_mb = peakResidentMegabytes();
  stats.skipped_bytes = log.skippedBytes();
  stats.truncated = log.truncated();
  return stats;
}

}  // namespace slam
