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
#include <memory>
#include <numbers>
#include <stdexcept>
#include <variant>

#include "slam/back_end.hpp"
#include "slam/localizer.hpp"
#include "tools/bench/log_truth.hpp"

namespace slam {
namespace {

PlaceError errorOf(const Pose2& found, const Pose2& truth) {
  const Pose2 error = between(truth, found);
  return {std::hypot(error.x, error.y), std::abs(error.theta) * 180.0 / std::numbers::pi};
}

/// A robot in a given map, fed with samples in their order.
class Robot {
 public:
  Robot(const Config& config, const BackEndConfig& back_end, const MapState& map)
      : localizer_(
            std::make_unique<Localizer>(localizerConfig(config), nullptr,
                                        LocalizerStart{.first_keyframe = map.keyframes.size(), .in_known_map = true})),
        back_end_(back_end) {
    back_end_.load(map.keyframes, map.in_map);
  }

  void add(const LogSample& sample) {
    if (const auto* wheels = std::get_if<WheelSample>(&sample)) localizer_->add(*wheels);
    if (const auto* imu = std::get_if<ImuSample>(&sample)) localizer_->add(*imu);
    if (const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample)) addScan(**scan);
  }

  Pose2 pose() const { return pose_; }
  bool placed() const { return localizer_->placed(); }
  const std::vector<double>& searchMilliseconds() const { return search_ms_; }
  int searches() const { return back_end_.counters().relocalisation.searches; }
  const PlaceSearch::Result& newestSearch() const { return back_end_.newestSearch(); }

 private:
  void addScan(const LaserScan& scan) {
    const ScanOutcome outcome = localizer_->add(scan);
    if (outcome.keyframe != nullptr) addKeyframe(*outcome.keyframe);
    pose_ = localizer_->estimate(outcome.stamp).T_map_base;
  }
  void addKeyframe(const Keyframe& keyframe) {
    const int before = searches();
    const auto start = std::chrono::steady_clock::now();
    back_end_.add(keyframe);
    if (searches() > before) {
      search_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    if (auto correction = back_end_.takeCorrection()) {
      localizer_->apply(*correction);
      back_end_.recycle(std::move(correction));
    }
  }

  std::unique_ptr<Localizer> localizer_;
  BackEnd back_end_;
  Pose2 pose_;
  std::vector<double> search_ms_;
};

}  // namespace

ColdStartReport coldStarts(const std::filesystem::path& log, const Config& config, const MapState& map, int places,
                           double seconds, bool believe_none, const std::function<void(int done)>& progress) {
  const std::vector<LogSample> samples = readSamples(log);
  const LogTruth truth = fitLog(samples, config, map);
  std::vector<std::size_t> scans;  // sample of each row
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::holds_alternative<std::unique_ptr<LaserScan>>(samples[i])) scans.push_back(i);
  }
  BackEndConfig back_end = backEndConfig(config);
  if (believe_none) back_end.relocalisation.places.min_lead = std::numeric_limits<double>::infinity();
  ColdStartReport report;
  report.truth_seen = truth.seen;
  report.truth_lead = truth.lead;
  const auto stampOf = [&](std::size_t row) { return truth.rows[row].stamp; };
  const Duration longest = fromSeconds(seconds);
  const Duration span = stampOf(scans.size() - 1) - stampOf(0) - longest;
  for (int place = 0; place < places; ++place) {
    const Timestamp begin = stampOf(0) + place * span / places;
    std::size_t row = 0;
    while (stampOf(row) < begin) ++row;
    Robot robot(config, back_end, map);
    ColdStart start;
    start.begin = toSeconds(begin - stampOf(0));
    for (std::size_t i = scans[row]; i < samples.size() && row < scans.size(); ++i) {
      if (stampOf(row) - begin > longest) break;
      const int searches = robot.searches();
      robot.add(samples[i]);
      if (i != scans[row]) continue;
      const double after = toSeconds(stampOf(row) - begin);
      if (robot.searches() > searches && robot.newestSearch().outcome != PlaceSearch::Outcome::kElsewhere) {
        const PlaceSearch::Result& found = robot.newestSearch();
        start.searches.push_back({after, found.lead, errorOf(found.T_map_newest, truth.rows[row].T_map_base)});
      }
      if (robot.placed()) {
        start.found = true;
        start.after = after;
        start.T_map_base = robot.pose();
        start.error = errorOf(robot.pose(), truth.rows[row].T_map_base);
        break;
      }
      ++row;
    }
    ++(!start.found ? report.not_yet : start.error.right() ? report.right : report.wrong);
    report.starts.push_back(start);
    const auto& times = robot.searchMilliseconds();
    report.search_ms.insert(report.search_ms.end(), times.begin(), times.end());
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
      out << (&search == &start.searches.front() ? "" : " ") << search.after << " " << search.lead;
    }
    out << "\n";
  }
  out.close();
  if (!out) throw std::runtime_error(csv.string() + ": cannot write all of it: " + std::strerror(errno));
}

}  // namespace slam
