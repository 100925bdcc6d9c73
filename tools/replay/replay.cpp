// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/replay.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <limits>
#include <optional>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "mapping/map_files.hpp"
#include "matching/deskew.hpp"
#include "runtime/process_usage.hpp"
#include "slam/back_end.hpp"
#include "slam/map_import.hpp"
#include "slam/motion_probe.hpp"
#include "store/map_store.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/replay/estimates.hpp"
#include "tools/replay/viewer_frames.hpp"

namespace slam {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kFewStuck = 5, kFewStuckShare = 0.01;  // scans of a stuck lidar, [1] of all: no more is no fault

double microsecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

Timestamp stopwatch() { return Timestamp(std::chrono::duration_cast<Duration>(Clock::now().time_since_epoch())); }

std::optional<TrajectoryWriter> writerFor(const std::filesystem::path& file) {
  return file.empty() ? std::nullopt : std::optional<TrajectoryWriter>(file);
}

/// One run: the log's samples go through the same Localizer and Mapper as in the daemon.
class Run {
 public:
  Run(const Config& config, const ReplayOptions& options, std::optional<MapState> map)
      : use_lidar_(config.lidar_device.driver != "none"),
        use_wheels_(config.base_device.driver != "none"),
        use_imu_(config.imu_device.driver != "none"),
        use_depth_(config.depth_device.driver != "none"),
        localise_only_(config.mode == "localise"),
        localizer_(localizerConfig(config), &stopwatch, map ? startIn(*map) : LocalizerStart{}),
        probe_(config.localizer),
        back_end_(backEndConfig(config)),
        mapper_(config.map),
        final_(writerFor(options.trajectory)),
        causal_(writerFor(options.causal)),
        odometry_(writerFor(options.odometry)),
        wheels_(writerFor(options.wheels)) {
    if (!options.estimates.empty()) estimates_.emplace(options.estimates);
    if (!options.viewer_frames.empty()) viewer_.emplace(options.viewer_frames, options.viewer_period);
    if (!map) return;
    mapper_.load(scansOf(*map), viewsOf(*map), std::move(map->grid), map->grid_keyframes);
    back_end_.load(std::move(map->keyframes), std::move(map->in_map));
  }

  /// @param log_s [s] of the event since the log's begin
  void feed(const LogEvent& event, double log_s) {
    log_s_ = log_s;
    if (event.channel == channel::kScan && use_lidar_) {
      const auto message = decodeChecked<scan_t>(event.data);
      const auto scan = message ? fromMessage(*message) : std::nullopt;
      scan ? addScan(*scan, message->utime) : reject();
    } else if (event.channel == channel::kWheels && use_wheels_) {
      const auto message = decodeChecked<wheels_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      sample ? addWheels(*sample, message->utime) : reject();
    } else if (event.channel == channel::kImu && use_imu_) {
      const auto message = decodeChecked<imu_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      sample ? addImu(*sample) : reject();
    } else if (event.channel == channel::kDepth && use_depth_) {
      const auto message = decodeChecked<depth_t>(event.data);
      const auto laser = message ? fromMessage(*message) : std::nullopt;
      laser ? addDepth(*laser) : reject();
    }
  }

  ReplayStats finish(const ReplayOptions& options) {
    for (const Row& row : poses_) {
      const Pose2 T_map_keyframe =
          row.anchored.keyframe < 0 ? Pose2{} : back_end_.keyframes().pose(row.anchored.keyframe);
      if (final_) final_->write(row.utime, T_map_keyframe * row.anchored.T_keyframe_base);
    }
    stats_.loop_closures = back_end_.counters().loop_closures;
    stats_.revoked = back_end_.counters().revoked;
    stats_.relocalised = back_end_.counters().placed;
    stats_.begun_anew = back_end_.counters().begun_anew;
    for (auto* writer : {&final_, &causal_, &odometry_, &wheels_}) {
      if (*writer) (*writer)->close();
    }
    if (estimates_) estimates_->close();
    mapper_.work(std::numeric_limits<int>::max());
    if (!options.save_map.empty()) saveMap(options.save_map);
    if (!options.map.empty()) writeMapFiles(options.map, renderMap(mapper_.grid()), mapper_.path());
    stats_.localizer = localizer_.counters();
    stats_.lidar_gyro_offset = offset_.estimate();
    bool explained = false;
    const SensorFindings findings = withDistances(probe_.findings(), localizer_.wheelScale());
    for (const SensorFinding& finding : findings.all()) {
      stats_.warnings.push_back(describe(finding));
      explained |= finding.fault != SensorFault::kScansRepeated && finding.fault != SensorFault::kTimeBackwards;
    }
    if (scans_stuck_ > std::max(kFewStuck, kFewStuckShare * stats_.localizer.scans)) {
      stats_.warnings.push_back(
          "the lidar was stuck: " + std::to_string(scans_stuck_) +
          " scans show the ranges of the turn before although the robot moves; they were left out; "
          "look after its cable and power");
    }
    if (const auto times = stats_.localizer.wheels_withdrawn; times > 0 && !explained) {
      stats_.warnings.push_back("the wheels contradicted the scans and were not heard, " + std::to_string(times) +
                                " times: do they slip, lag behind, or have a wrong radius or sign?");
    }
    if (stats_.localizer.scans > 0 && stats_.localizer.matched + stats_.localizer.partly_observable == 0) {
      stats_.warnings.emplace_back(
          "no scan was matched: are its ranges finite and between range_min and range_max, and "
          "its stamps near those of wheels and IMU?");
    }
    if (viewer_) {
      drawFrame();
      viewer_->close();
    }
    return std::move(stats_);
  }

 private:
  void reject() { ++stats_.rejected_messages; }

  void addImu(const ImuSample& sample) {
    localizer_.add(sample);
    probe_.add(sample);
    offset_.addGyro(sample.stamp + fromSeconds(localizer_.config().imu_time_offset), sample.gyro.z());
  }

  void addDepth(const PseudoLaser& laser) {
    const DepthSight* sight = localizer_.add(laser);
    const auto view = sight != nullptr ? back_end_.mapView(*sight) : std::nullopt;
    if (!view) return;
    mapper_.work(std::numeric_limits<int>::max());  // views that come while the map is drawn anew are not kept
    mapper_.add(*view);
  }

  void addWheels(const WheelSample& sample, std::int64_t utime) {
    localizer_.add(sample);
    probe_.add(sample);
    if (wheels_) wheels_->write(utime, sample.T_wheels_base);
  }

  void addScan(const LaserScan& scan, std::int64_t utime) {
    const auto start = Clock::now();
    const ScanOutcome outcome = slam::addScan(localizer_, probe_, scan);
    const ScanEstimate known = estimateOf(localizer_, outcome, utime);
    const Pose2& T_map_base = known.T_map_base;
    stats_.scan_us.push_back(microsecondsSince(start));
    probe_.work();
    scans_stuck_ += outcome.stuck;
    if (outcome.fused && outcome.match.observable == 3) offset_.addScan(outcome.stamp, outcome.match.T_ref_base.theta);
    if (outcome.match.iterations > 0) stats_.match_us.push_back(1e6 * toSeconds(outcome.match_time));
    // Before a correction moves the keyframes; in a given map, whose keyframes stay, the pose is its own anchor.
    poses_.push_back({utime, localizer_.segment(),
                      localise_only_ ? Localizer::Anchored{-1, T_map_base} : localizer_.anchor(T_map_base)});
    if (outcome.keyframe != nullptr) {
      const auto begin = Clock::now();
      back_end_.add(*outcome.keyframe);
      mapper_.forgetBefore(back_end_.firstInMap());
      for (const MapScan& drawn : back_end_.mapScans(*outcome.keyframe)) mapper_.add(drawn);
      if (generation_ != back_end_.generation()) {
        stats_.optimise_ms.push_back(1e-3 * microsecondsSince(begin));
        mapper_.move(back_end_.keyframes().graph().poses());  // drawn when somebody looks
        generation_ = back_end_.generation();
      }
      if (auto correction = back_end_.takeCorrection()) {
        if (localise_only_ && correction->T_map_segment) placeRows(*correction->T_map_segment);
        localizer_.apply(*correction);
        back_end_.recycle(std::move(correction));
      }
    }
    if (causal_) causal_->write(utime, T_map_base);
    if (odometry_) odometry_->write(utime, known.T_odom_base);
    if (estimates_) estimates_->write(known);
    if (viewer_) {
      see(scan, outcome.first);
      if (viewer_->due(log_s_)) drawFrame();
    }
  }

  /// Keeps the scan for the next frame.
  void see(const LaserScan& scan, Timestamp stamp) {
    const LidarModel& lidar = localizer_.config().lidar;
    PoseHistory motion(2);
    const Timestamp end = stamp + (scan.size > 0 ? fromSeconds(scan.beams().back().time_offset) : Duration(0));
    for (const Timestamp t : {stamp, end}) motion.push(t, localizer_.odometry(t).T_odom_base);
    deskew(scan, {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)}, stamp, lidar.mounting(),
           motion, points_);
    seen_.clear();
    for (const ScanPoint& point : points_) seen_.push_back(point.position);
    seen_stamp_ = stamp;
  }

  void drawFrame() {
    mapper_.work(std::numeric_limits<int>::max());
    const PoseGraph& graph = back_end_.keyframes().graph();
    viewer_->write(renderMap(mapper_.grid()), {.log_s = log_s_,
                                               .T_map_base = localizer_.estimate(seen_stamp_).T_map_base,
                                               .scan = seen_,
                                               .keyframes = graph.poses(),
                                               .edges = graph.edges()});
  }

  void saveMap(const std::filesystem::path& path) {
    const Timestamp now = poses_.empty() ? Timestamp{} : localizer_.newestStamp();
    const PoseEstimate pose = localizer_.estimate(now);
    MapState map;
    map.keyframes = back_end_.keyframes();
    map.in_map = back_end_.inMap();
    map.grid = mapper_.grid().clone();
    map.views = mapper_.views();
    map.grid_keyframes = map.keyframes.size();
    map.T_map_base = pose.T_map_base;
    map.gyro_bias = localizer_.odometry(now).gyro_bias;
    map.T_base_lidar = localizer_.config().lidar.T_base_lidar;
    map.range_max = localizer_.config().lidar.range_max;
    map.utime = poses_.empty() ? 0 : poses_.back().utime;
    const auto folder = std::filesystem::absolute(path).lexically_normal();
    MapStore store(folder.parent_path(), folder.filename());
    const FolderLock lock(folder);
    store.checkpoint(map);
  }

  /// The segment was found: where the robot was since it got lost is known now.
  void placeRows(const Pose2& T_map_segment) {
    for (auto row = poses_.rbegin(); row != poses_.rend() && row->segment == localizer_.segment(); ++row) {
      row->anchored.T_keyframe_base = T_map_segment * row->anchored.T_keyframe_base;
    }
  }

  struct Row {
    std::int64_t utime;
    std::int32_t segment;
    Localizer::Anchored anchored;
  };

  bool use_lidar_, use_wheels_, use_imu_, use_depth_;  // a driver of "none" is left out of the log, too
  bool localise_only_;
  Localizer localizer_;
  MotionProbe probe_;
  LidarGyroOffset offset_;
  BackEnd back_end_;
  Mapper mapper_;
  std::optional<TrajectoryWriter> final_, causal_, odometry_, wheels_;
  std::optional<EstimateWriter> estimates_;
  int scans_stuck_ = 0;
  std::vector<Row> poses_;
  int generation_ = 0;  // of the back end's poses in the map
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
  const std::string mismatch = lidarMismatch(loaded.state, config.localizer.lidar);
  if (!mismatch.empty()) throw std::runtime_error(path.string() + ": " + mismatch);
  if (loaded.state.picture_only && config.mode != "localise") {
    throw std::runtime_error(path.string() + ": a picture of a map cannot be extended; set mode to \"localise\"");
  }
  return std::move(loaded.state);
}

}  // namespace

std::optional<config_t> configOf(const std::vector<std::filesystem::path>& logs) {
  EventLogSequence log(logs);
  LogEvent event;
  return log.next(event) && event.channel == channel::kConfig ? decodeChecked<config_t>(event.data) : std::nullopt;
}

ReplayStats replay(const Config& config, const ReplayOptions& options,
                   const std::function<void(double log_seconds)>& progress) {
  const auto start = Clock::now();
  const double cpu_before = cpuSeconds();
  EventLogSequence log(options.logs);
  std::optional<MapState> map;
  if (!options.load_map.empty()) map = loadMap(config, options.load_map);
  if (!map && config.mode == "localise") throw std::runtime_error("mode \"localise\" needs a map; give --load-map");
  Config fitting = config;
  if (map && map->picture_only) {
    fitting.localizer.match = matchInPicture(config.localizer.match, map->grid.resolution());
  }
  Run run(fitting, options, std::move(map));
  std::int64_t first = 0, last = 0;
  for (LogEvent event; log.next(event);) {
    if (first == 0) first = event.utime;
    last = std::max(last, event.utime);
    const double log_s = 1e-6 * static_cast<double>(last - first);
    run.feed(event, log_s);
    if (progress) progress(log_s);
  }
  ReplayStats stats = run.finish(options);
  if (stats.localizer.scans == 0) {
    throw std::runtime_error(options.logs.front().string() +
                             ": no SLAM_SCAN in it; slam-convert makes logs for slam-replay");
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
