// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/replay.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <optional>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "diagnostics/sensor_problems.hpp"
#include "mapping/map_files.hpp"
#include "runtime/process_usage.hpp"
#include "slam/pipeline.hpp"
#include "slam/refine/map_refinement.hpp"
#include "store/edit_files.hpp"
#include "store/map_store.hpp"
#include "tools/common/output_file.hpp"
#include "tools/replay/estimates.hpp"
#include "tools/replay/run_parts.hpp"

namespace slam {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::uint32_t kFewMatched = 3;  // times as many scans that were not matched are too many

double microsecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

Timestamp stopwatch() { return Timestamp(std::chrono::duration_cast<Duration>(Clock::now().time_since_epoch())); }

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
      : scans_(channel::kScan, config.lidar_device.driver != LidarDriver::kNone),
        wheels_(channel::kWheels, config.base_device.driver != BaseDriver::kNone),
        imus_(channel::kImu, config.imu_device.driver != ImuDriver::kNone),
        depths_(channel::kDepth, config.depth_device.driver != DepthDriver::kNone),
        pipeline_({frontEndConfig(config), backEndConfig(config), config.map, drawsMap(options)}, map, &stopwatch),
        poses_(options, config.mode == RunMode::kLocalise) {
    if (!options.save_map.empty()) store_.emplace(options.save_map);
    if (!options.estimates.empty()) estimates_.emplace(options.estimates);
    if (!options.viewer_frames.empty()) frames_.emplace(options.viewer_frames, options.viewer_period);
    pipeline_.on_scan = [this](const ScanOutcome& outcome) { write(outcome); };
    pipeline_.on_update = [this](const MapUpdate& update) { note(update); };
  }

  /// @param log_s [s] of the event since the log's begin
  void feed(const LogEvent& event, double log_s) {
    log_s_ = log_s;
    scans_.take(event, [&](const scan_t& message, const LaserScan& scan) {
      stats_.thinned_beams += static_cast<std::uint64_t>(thinnedBeams(message));
      addScan(scan, message.utime);
    });
    wheels_.take(event, [&](const wheels_t& message, const WheelSample& sample) {
      pipeline_.add(sample);
      poses_.addWheels(message.utime, sample.T_wheels_base);
    });
    imus_.take(event, [&](const imu_t&, const ImuSample& sample) { pipeline_.add(sample); });
    depths_.take(event, [&](const depth_t&, const auto& view) { pipeline_.add(view); });
  }

  /// Whether the robot is being looked for in the map.
  bool lost() const { return !pipeline_.frontEnd().placed(); }

  /// How many scans were refused and why; empty: none.
  std::string refusedScans() const { return scans_.refusals(); }

  ReplayStats finish(const Config& config, const ReplayOptions& options) {
    std::optional<MapState> refined;  // where that made the map better
    if (options.refine) refined = refine(config);
    const KeyframeGraph& keyframes = refined ? refined->keyframes : pipeline_.backEnd().keyframes();
    poses_.finish(keyframes);
    if (estimates_) estimates_->close();
    if (!options.map.empty()) writeMap(options.map, config.map, refined);
    if (!options.save_map.empty()) saveMap(refined ? std::move(*refined) : pipeline_.state());
    countInputs();
    stats_.front_end = pipeline_.frontEnd().counters();
    stats_.filter = pipeline_.frontEnd().filterCounters();
    stats_.back_end = pipeline_.backEnd().counters();
    stats_.lidar_gyro_offset = pipeline_.frontEnd().lidarDelay().estimate();
    if (!config.store.floors.empty())
      stats_.warnings.push_back(
          "store.floors is not used: a log is replayed in one map; slam-benchmark lift changes maps");
    warn();
    if (frames_) frames_->finish(log_s_, pipeline_);
    return std::move(stats_);
  }

 private:
  void countInputs() {
    const auto count = [this](const auto& input) {
      stats_.rejected_messages += input.rejected();
      if (const std::string words = input.refusals(); !words.empty()) stats_.refusals.push_back(words);
    };
    count(scans_);
    count(wheels_);
    count(imus_);
    count(depths_);
  }

  /// Of sensors that contradict each other.
  void warn() {
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
    lidar_.warn(stats_);
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
  }

  void addScan(const LaserScan& scan, std::int64_t utime) {
    utime_ = utime;
    lidar_.add(scan, pipeline_.frontEnd().config().lidar);
    begin_ = Clock::now();
    const ScanOutcome outcome = pipeline_.add(scan);
    if (frames_) frames_->add(scan, outcome.first, log_s_, pipeline_);
  }

  void write(const ScanOutcome& outcome) {
    if (outcome.misdated) return;  // nobody knows of which moment its pose is
    const FrontEnd& front_end = pipeline_.frontEnd();
    const ScanEstimate known = estimateOf(front_end, outcome, utime_);
    stats_.scan_us.push_back(microsecondsSince(begin_));
    lidar_.noteStuck(outcome.stuck);
    stats_.wheels_died |= pipeline_.frontEnd().wheelsDead();
    if (outcome.match.iterations > 0) stats_.match_us.push_back(1e6 * toSeconds(outcome.match_time));
    poses_.add(utime_, known, front_end);
    if (estimates_) estimates_->write(known);
  }

  void note(const MapUpdate& update) {
    if (!update.poses.empty()) stats_.optimise_ms.push_back(1e3 * toSeconds(update.work));
    if (update.correction && update.correction->T_map_session)
      poses_.place(*update.correction->T_map_session, pipeline_.frontEnd().session());
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
    map.utime = poses_.lastUtime();
    store_->store.checkpoint(map);
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

  SensorInput<scan_t> scans_;  // a driver of "none" is left out of the log, too
  SensorInput<wheels_t> wheels_;
  SensorInput<imu_t> imus_;
  SensorInput<depth_t> depths_;
  Pipeline pipeline_;
  RunPoses poses_;
  std::optional<RunFrames> frames_;
  std::optional<EstimateWriter> estimates_;
  std::optional<Destination> store_;
  LidarWatch lidar_;
  std::int64_t utime_ = 0;   // [us] of the scan being used ...
  Clock::time_point begin_;  // ... and when that began
  double log_s_ = 0.0;
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
