// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/live_report.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <slam/health_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "core/estimates.hpp"
#include "mapping/map_files.hpp"
#include "tools/eval/map_metrics.hpp"
#include "tools/eval/metrics.hpp"

namespace slam {
namespace {

/// What a record says, by channel.
struct Record {
  Trajectory wheels, odometry, slam;
  std::vector<std::int64_t> slam_utimes;
  std::optional<health_t> health;  // the last
};

/// For our own record: its lengths were written by slamd, not by a stranger.
template <typename Message>
std::optional<Message> decodeOwn(const LogEvent& event) {
  Message message{};
  const int size = static_cast<int>(event.data.size());
  return message.decode(event.data.data(), 0, size) == size ? std::optional(message) : std::nullopt;
}

Record readRecord(const std::filesystem::path& file) {
  Record record;
  EventLogReader log(file);
  for (LogEvent event; log.next(event);) {
    if (event.channel == channel::kWheels) {
      if (const auto m = decodeChecked<wheels_t>(event.data)) {
        record.wheels.push_back({fromMicroseconds(m->utime), {m->x, m->y, m->theta}});
      }
    } else if (event.channel == channel::kOdometry) {
      if (const auto m = decodeOwn<odometry_t>(event)) {
        record.odometry.push_back({fromMicroseconds(m->utime), {m->x, m->y, m->theta}});
      }
    } else if (event.channel == channel::kSlamPose) {
      const auto m = decodeOwn<pose_estimate_t>(event);
      if (!m || m->state == static_cast<std::uint8_t>(LocalisationState::kInitialising)) continue;
      record.slam.push_back({fromMicroseconds(m->utime), {m->x, m->y, m->theta}});
      record.slam_utimes.push_back(m->utime);
    } else if (event.channel == channel::kHealth) {
      if (auto m = decodeOwn<health_t>(event)) record.health = std::move(m);
    }
  }
  if (record.slam.empty()) throw std::runtime_error(file.string() + ": no SLAM_POSE with a pose in it");
  return record;
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

void printAccuracy(const LiveInput& input, const Record& record) {
  const Trajectory truth = readTrajectory(input.truth);
  std::optional<Trajectory> waypoints;
  if (!input.waypoints.empty() && std::filesystem::file_size(input.waypoints) > 0)
    waypoints = readTrajectory(input.waypoints);

  std::printf(
      "| accuracy against the truth | whole drive, RMSE [m] | worst [m] | waypoints | position mean / worst [m] | "
      "heading mean / worst [deg] |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const auto& [name, trajectory] : {std::pair<const char*, const Trajectory*>("wheels alone", &record.wheels),
                                         {"fused odometry (wheels, IMU)", &record.odometry},
                                         {"SLAM (published live)", &record.slam}}) {
    if (trajectory->empty()) continue;
    const AteErrors ate = absoluteErrors(*trajectory, truth, false);
    std::printf("| %s | %.4f | %.4f |", name, ate.rmse, ate.max);
    const WaypointErrors at = waypoints ? waypointErrors(*trajectory, *waypoints) : WaypointErrors{};
    if (at.position.empty()) {
      std::printf(" none reached | | |\n");
    } else {
      std::printf(" %zu | %.4f / %.4f | %.3f / %.3f |\n", at.position.size(), meanAndDeviation(at.position).mean,
                  largest(at.position), meanAndDeviation(at.heading).mean, largest(at.heading));
    }
  }
}

void printMap(const LiveInput& input) {
  if (input.map.empty() || input.truth_map.empty()) return;
  const MapErrors map = compareMaps(readMapFiles(input.map), readMapFiles(input.truth_map));
  std::printf("\n| map in the robot's height band | |\n|---|---|\n");
  std::printf("| known, of the cells the robot could see | %.1f %% |\n", 100.0 * map.completeness);
  std::printf("| occupied cells: precision, recall | %.1f %%, %.1f %% |\n", 100.0 * map.occupied.precision,
              100.0 * map.occupied.recall);
  std::printf("| free cells: precision, recall | %.1f %%, %.1f %% |\n", 100.0 * map.free.precision,
              100.0 * map.free.recall);
}

void printHealth(const health_t& health) {
  const auto counter = [&](const std::string& name) -> long long {
    for (const counter_t& c : health.counters) {
      if (c.name == name) return static_cast<long long>(c.value);
    }
    return 0;
  };
  std::printf("\n| daemon, after %.0f s | p50 | p99 | worst |\n|---|---|---|---|\n", health.uptime);
  for (const auto& [name, title] : {std::pair("scan_to_pose", "scan complete to POSE on LCM [ms]"),
                                    {"scan_work", "work on one scan [ms]"},
                                    {"match", "of it the match [ms]"},
                                    {"estimator.late", "estimator: tick begins late by [ms]"},
                                    {"base.late", "base: tick begins late by [ms]"},
                                    {"map", "map update [ms]"}}) {
    for (const stage_health_t& s : health.stages) {
      if (s.name == name)
        std::printf("| %s | %.3f | %.3f | %.3f |\n", title, s.p50_us * 1e-3, s.p99_us * 1e-3, s.max_us * 1e-3);
    }
  }
  const double ticks = static_cast<double>(std::max(1LL, counter("estimator.ticks")));
  std::printf("\n| daemon | |\n|---|---|\n");
  std::printf("| estimator ticks that missed their deadline | %lld of %.0f (%.3f %%) |\n",
              counter("estimator.overruns"), ticks, 100.0 * static_cast<double>(counter("estimator.overruns")) / ticks);
  std::printf("| scans matched, partly observable, refused, gated | %lld, %lld, %lld, %lld |\n",
              counter("scans.matched"), counter("scans.partly_observable"), counter("scans.unmatched"),
              counter("scans.gated"));
  std::printf("| CPU, memory | %.1f %% of a core, %.0f MB |\n", 100.0 * health.cpu, health.memory_mb);
  std::printf("| of it threads base, lidar, depth, estimator, mapper |");
  for (const char* const thread : {"base", "lidar", "depth", "estimator", "mapper"}) {
    const auto cpu_ms = static_cast<double>(counter(thread + std::string(".cpu_ms")));
    std::printf("%s %.2f %%", thread == std::string_view("base") ? "" : ",", 0.1 * cpu_ms / health.uptime);
  }
  std::printf(" |\n| state | %s |\n", health.summary.c_str());
}

}  // namespace

void printLiveReport(const LiveInput& input) {
  const Record record = readRecord(input.record);
  if (!input.trajectory.empty()) {
    TrajectoryWriter writer(input.trajectory);
    for (std::size_t i = 0; i < record.slam.size(); ++i) writer.write(record.slam_utimes[i], record.slam[i].pose);
    writer.close();
  }
  printAccuracy(input, record);
  printMap(input);
  if (record.health) printHealth(*record.health);
}

}  // namespace slam
