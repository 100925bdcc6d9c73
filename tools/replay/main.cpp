// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "config/loader.hpp"
#include "store/log_folder.hpp"
#include "tools/common/output_file.hpp"
#include "tools/common/program.hpp"
#include "tools/common/refinement_words.hpp"
#include "tools/replay/replay.hpp"

namespace {

/// Says what the log tells of the lidar's stamps against the gyro's, once it is more than noise.
void printOffset(const slam::ReplayStats& stats, double configured) {
  constexpr double kNoticed = 0.002;  // [s]
  if (!stats.lidar_gyro_offset) return;
  const auto& [offset, sigma, turns, gyro_bias] = *stats.lidar_gyro_offset;
  std::printf("lidar to gyro: %+.1f ms (sigma %.1f ms, %d turns)", 1e3 * offset, 1e3 * sigma, turns);
  if (std::abs(offset) > std::max(3.0 * sigma, kNoticed) && !stats.turns_differ)
    std::printf("; set lidar.time_offset = %.4f", configured + offset);
  std::printf("\n");
}

void printSummary(const slam::ReplayStats& stats) {
  const auto& l = stats.front_end;
  std::printf("%u scans of %.1f s: %u matched, %u partly observable, %u not matched; %u keyframes, %d loop closures\n",
              l.scans, stats.log_s, l.matched, l.partly_observable, stats.notMatched(), l.keyframes,
              stats.back_end.loop_closures);
  if (const auto& r = stats.back_end.relocalisation; r.searches + r.interrupted > 0) {
    std::printf(
        "%d searches for the lost robot: %d found it, %d found places that look alike, %d none; one went on with "
        "a later scan %d times\n",
        r.searches, r.found, r.ambiguous, r.refused, r.interrupted);
  }
  std::printf(
      "CPU %.2f s (%.0f times real time), peak memory %.1f MB, match p50 %.0f us, scan p50 %.0f us p99 %.0f us\n",
      stats.cpu_s, stats.log_s / std::max(1e-9, stats.cpu_s), stats.peak_rss_mb, slam::quantiles(stats.match_us).p50,
      slam::quantiles(stats.scan_us).p50, slam::quantiles(stats.scan_us).p99);
}

/// The configuration that a field log brings.
slam::Config ownConfig(const std::vector<std::filesystem::path>& logs, const std::vector<std::string>& overrides) {
  const auto own = slam::configOf(logs);
  if (!own) {
    throw CLI::ValidationError(
        "--config", "is required: " + logs.front().string() + " has no configuration (SLAM_CONFIG) of its own");
  }
  const slam::Config config =
      slam::parseConfig(own->configuration, "SLAM_CONFIG in " + logs.front().string(), overrides);
  std::cerr << "slam-replay: configuration of the log itself (" << own->versions << ", on " << own->host << ")\n";
  return config;
}

void warnOfDamage(const std::string& log, const slam::ReplayStats& stats) {
  if (stats.truncated) std::cerr << "slam-replay: " << log << ": its last record is cut off; used all before it\n";
  if (stats.skipped_bytes > 0) {
    std::cerr << "slam-replay: " << log << ": skipped " << stats.skipped_bytes << " damaged bytes\n";
  }
  for (const std::string& refusal : stats.refusals) std::cerr << "slam-replay: " << log << ": " << refusal << "\n";
  if (stats.thinned_beams > 0) {
    std::cerr << "slam-replay: " << log << ": scans have more beams than are used; left " << stats.thinned_beams
              << " out, evenly\n";
  }
  if (stats.front_end.clock_resets > 0) {
    std::cerr << "slam-replay: " << log << ": time went back by seconds " << stats.front_end.clock_resets << " times\n";
  }
  for (const std::string& warning : stats.warnings) std::cerr << "warning: " << warning << "\n";
}

/// What the command line asks for beside the replay itself.
struct Arguments {
  std::string config_file, stats_file;
  std::vector<std::string> overrides;
};

void addOptions(CLI::App& app, Arguments& arguments, slam::ReplayOptions& options) {
  app.add_option("--config", arguments.config_file,
                 "slamd configuration (TOML); may be left out for a field log, which has its own");
  app.add_option("--set", arguments.overrides, "section.key=value over the file; may be repeated");
  app.add_option("--log", options.logs,
                 "LCM event log with SLAM_SCAN, SLAM_WHEELS, SLAM_IMU, plain or gzip; several, or a folder of slamd's "
                 "field logs, are read in order")
      ->required();
  app.add_option("--trajectory", options.trajectory, "write final poses, one a scan (TUM)");
  app.add_option("--causal", options.causal, "write poses as known at each scan's time (TUM)");
  app.add_option("--estimates", options.estimates,
                 "write what was known when each scan had been used (CSV; its first row names the columns): t [s] as "
                 "recorded, state, pose in map at t as in --causal with its covariance [m, rad], pose in odom as in "
                 "--odometry, the matcher's status and overlap [1]; one row a scan as in --trajectory, with status "
                 "none for scans that were not matched (the first, copies, too late, of a stuck lidar)");
  app.add_option("--odometry", options.odometry, "write fused wheels and IMU, without lidar (TUM)");
  app.add_option("--wheels", options.wheels, "write the wheels' own dead reckoning, one row a wheel sample (TUM)");
  app.add_option("--load-map", options.load_map,
                 "begin in this map: DIR/NAME of a store; with mode = \"localise\" also a map_server .yaml");
  app.add_option("--save-map", options.save_map, "write the map with its graph, to go on in it: DIR/NAME");
  app.add_flag("--refine", options.refine,
               "at the end compute the map once more from all that its keyframes hold, as slamctl refine does; final "
               "poses and map are the better ones");
  app.add_option("--map", options.map, "write map files with this prefix (.yaml .pgm .png)");
  app.add_option("--viewer-frames", options.viewer_frames,
                 "write pictures of map, robot, scan, path and loop closures into this folder, which is made");
  app.add_option("--viewer-period", options.viewer_period, "[s] of log time between pictures")
      ->check(slam::inRange(0.01, 1e6))
      ->capture_default_str();
  app.add_option("--stats", arguments.stats_file, "write statistics (JSON)");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Runs slamd's pipeline over a recorded log", "slam-replay");
  Arguments arguments;
  slam::ReplayOptions options;
  addOptions(app, arguments, options);
  return slam::runProgram(
      app, argc, argv, SLAMD_VERSION,
      "slam-replay --config config/carmen.toml --log intel.lcm --trajectory intel.tum --map out/intel", [&] {
        options.logs = slam::logPaths(options.logs);
        const slam::Config config = arguments.config_file.empty()
                                        ? ownConfig(options.logs, arguments.overrides)
                                        : slam::loadConfig(arguments.config_file, arguments.overrides);
        for (const std::string& line : config.notices) std::cerr << line << "\n";
        if (config.mode == slam::RunMode::kLocalise && options.refine)
          throw CLI::ValidationError("--refine", "mode \"localise\" changes no map; there is nothing to refine");
        if (config.mode == slam::RunMode::kLocalise && !options.save_map.empty()) {
          throw CLI::ValidationError("--save-map", "mode \"localise\" changes no map; there is nothing to save");
        }
        slam::prepareOutput(arguments.stats_file);
        int shown = -1;
        const slam::ReplayStats stats = slam::replay(config, options, [&](double seconds, bool lost) {
          const int now = static_cast<int>(seconds) / (lost ? 1 : 10);  // the search for a lost robot takes its time
          if (now == shown) return;
          shown = now;
          slam::showProgress("replaying: " + std::to_string(static_cast<int>(seconds)) + " s of the log" +
                             (lost ? ", looking for the lost robot in the map" : ""));
        });
        slam::endProgress();
        if (!arguments.stats_file.empty()) {
          std::ofstream out(arguments.stats_file);
          out << stats.json();
          if (!out.flush()) throw std::runtime_error(arguments.stats_file + ": cannot write");
        }
        warnOfDamage(options.logs.front().string() + (options.logs.size() > 1 ? " and following" : ""), stats);
        printSummary(stats);
        if (stats.refinement) std::printf("%s\n", slam::wordsOf(*stats.refinement, "of this log").c_str());
        printOffset(stats, config.front_end.lidar.time_offset);
        return slam::kDone;
      });
}
