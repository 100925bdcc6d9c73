// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/cold_starts.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <variant>

#include "tools/bench/log_truth.hpp"

namespace slam {
namespace {

Timestamp stopwatch() {
  return Timestamp(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

}  // namespace

PlaceError errorOf(const Pose2& found, const Pose2& truth) {
  const Pose2 error = between(truth, found);
  return {std::hypot(error.x, error.y), std::abs(error.theta) * 180.0 / std::numbers::pi};
}

ColdStartReport coldStarts(const std::filesystem::path& log, const Config& config, const MapState& map, int places,
                           double seconds, bool believe_none, const std::function<void(int done)>& progress) {
  const std::vector<LogSample> samples = readSamples(log);
  const LogTruth truth = fitLog(samples, config, map);
  return coldStarts(samples, truth, config, map, {places, seconds, believe_none}, progress);
}

ColdStartReport coldStarts(const std::vector<LogSample>& samples, const LogTruth& truth, const Config& config,
                           const MapState& map, const ColdStartOptions& options,
                           const std::function<void(int done)>& progress) {
  std::vector<std::size_t> scans;  // sample of each row
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::holds_alternative<std::unique_ptr<LaserScan>>(samples[i])) scans.push_back(i);
  }
  PipelineConfig robot{frontEndConfig(config), backEndConfig(config), config.map, false};
  if (options.believe_none) robot.back_end.relocalisation.places.min_margin = std::numeric_limits<double>::infinity();
  ColdStartReport report;
  report.truth_seen = truth.seen;
  report.truth_margin = truth.margin;
  const auto stampOf = [&](std::size_t row) { return truth.rows[row].stamp; };
  const Duration longest = fromSeconds(options.seconds);
  const Duration span = stampOf(scans.size() - 1) - stampOf(0) - longest;
  for (int place = 0; place < options.places; ++place) {
    const Timestamp begin = stampOf(0) + place * span / options.places;
    std::size_t row = 0;
    while (stampOf(row) < begin) ++row;
    Pipeline pipeline(robot, map, &stopwatch);
    const auto searches = [&] { return pipeline.backEnd().counters().relocalisation.searches; };
    pipeline.on_update = [&, before = 0](const MapUpdate& update) mutable {
      if (searches() > before) report.search_ms.push_back(1e3 * toSeconds(update.work));
      before = searches();
    };
    ColdStart start;
    start.begin = toSeconds(begin - stampOf(0));
    for (std::size_t i = scans[row]; i < samples.size() && row < scans.size(); ++i) {
      if (stampOf(row) - begin > longest) break;
      const int before = searches();
      const auto outcome = addTo(pipeline, samples[i]);
      if (i != scans[row]) continue;
      const double after = toSeconds(stampOf(row) - begin);
      if (searches() > before && pipeline.backEnd().newestSearch().outcome != PlaceSearch::Outcome::kElsewhere) {
        const PlaceSearch::Result& found = pipeline.backEnd().newestSearch();
        start.searches.push_back({after, found.margin, errorOf(found.T_map_newest, truth.rows[row].T_map_base)});
      }
      if (pipeline.frontEnd().placed()) {
        start.found = true;
        start.after = after;
        start.T_map_base = pipeline.frontEnd().estimate(outcome->stamp).T_map_base;
        start.error = errorOf(start.T_map_base, truth.rows[row].T_map_base);
        break;
      }
      ++row;
    }
    ++(!start.found ? report.not_yet : start.error.right() ? report.right : report.wrong);
    report.starts.push_back(start);
    if (progress) progress(place + 1);
  }
  return report;
}

void writeStarts(const ColdStartReport& report, const std::filesystem::path& csv) {
  std::ofstream out(csv);
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "begin_s,after_s,x_m,y_m,theta_rad,searches\n";
  for (const ColdStart& start : report.starts) {
    out << start.begin << ",";
    if (start.found) {
      out << start.after << "," << start.T_map_base.x << "," << start.T_map_base.y << "," << start.T_map_base.theta;
    } else {
      out << ",,,";
    }
    out << ",";
    for (const ColdSearch& search : start.searches) {
      out << (&search == &start.searches.front() ? "" : " ") << search.after << " " << search.margin;
    }
    out << "\n";
  }
  out.close();
  if (!out) throw std::runtime_error(csv.string() + ": cannot write all of it: " + std::strerror(errno));
}

}  // namespace slam
