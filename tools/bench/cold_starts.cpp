// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/cold_starts.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <variant>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "slam/back_end.hpp"
#include "slam/localizer.hpp"

namespace slam {
namespace {

constexpr double kRightDistance = 0.5;   // [m]
constexpr double kRightRotation = 10.0;  // [deg]

using Sample = std::variant<std::unique_ptr<LaserScan>, WheelSample, ImuSample>;

std::vector<Sample> readSamples(const std::filesystem::path& file) {
  EventLogReader log(file);
  std::vector<Sample> samples;
  for (LogEvent event; log.next(event);) {
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      if (const auto scan = message ? fromMessage(*message) : std::nullopt) {
        samples.emplace_back(std::make_unique<LaserScan>(*scan));
      }
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      if (const auto sample = message ? fromMessage(*message) : std::nullopt) samples.emplace_back(*sample);
    } else if (event.channel == channel::kImu) {
      const auto message = decodeChecked<imu_t>(event.data);
      if (const auto sample = message ? fromMessage(*message) : std::nullopt) samples.emplace_back(*sample);
    }
  }
  return samples;
}

/// A robot in a given map, fed with samples in their order.
class Robot {
 public:
  struct Row {
    Timestamp stamp;
    Pose2 T_map_base;
    std::int32_t segment;
  };

  Robot(const Config& config, const MapState& map)
      : localizer_(
            std::make_unique<Localizer>(localizerConfig(config), nullptr,
                                        LocalizerStart{.first_keyframe = map.keyframes.size(), .in_known_map = true})),
        back_end_(backEndConfig(config)) {
    back_end_.load(map.keyframes, map.in_map);
  }

  void add(const Sample& sample) {
    if (const auto* wheels = std::get_if<WheelSample>(&sample)) localizer_->add(*wheels);
    if (const auto* imu = std::get_if<ImuSample>(&sample)) localizer_->add(*imu);
    if (const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample)) addScan(**scan);
  }

  const std::vector<Row>& rows() const { return rows_; }
  bool placed() const { return localizer_->placed(); }
  const std::vector<double>& searchMilliseconds() const { return search_ms_; }
  double meanOverlap() const { return overlap_ / static_cast<double>(std::max<std::size_t>(1, rows_.size())); }
  int lost() const { return static_cast<int>(localizer_->counters().lost); }

 private:
  void addScan(const LaserScan& scan) {
    const ScanOutcome outcome = localizer_->add(scan);
    overlap_ += outcome.match.overlap;
    rows_.push_back({scan.stamp, localizer_->estimate(outcome.stamp).T_map_base, localizer_->segment()});
    if (outcome.keyframe == nullptr) return;
    const int searches = back_end_.counters().relocalisation.searches;
    const auto start = std::chrono::steady_clock::now();
    back_end_.add(*outcome.keyframe);
    if (back_end_.counters().relocalisation.searches > searches) {
      search_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    if (auto correction = back_end_.takeCorrection()) {
      if (correction->T_map_segment) placeRows(*correction->T_map_segment);
      localizer_->apply(*correction);
      back_end_.recycle(std::move(correction));
    }
  }
  void placeRows(const Pose2& T_map_segment) {
    for (auto row = rows_.rbegin(); row != rows_.rend() && row->segment == localizer_->segment(); ++row) {
      row->T_map_base = T_map_segment * row->T_map_base;
    }
  }

  std::unique_ptr<Localizer> localizer_;
  BackEnd back_end_;
  std::vector<Row> rows_;
  std::vector<double> search_ms_;
  double overlap_ = 0.0;
};

}  // namespace

ColdStartReport coldStarts(const std::filesystem::path& log, const Config& config, const MapState& map, int places,
                           double seconds) {
  const std::vector<Sample> samples = readSamples(log);
  Robot whole(config, map);
  std::vector<std::size_t> scans;  // sample of each row
  for (std::size_t i = 0; i < samples.size(); ++i) {
    whole.add(samples[i]);
    if (whole.rows().size() > scans.size()) scans.push_back(i);
  }
  if (scans.empty() || !whole.placed()) throw std::runtime_error(log.string() + ": the whole log does not find itself");

  ColdStartReport report;
  report.truth_overlap = whole.meanOverlap();
  report.truth_lost = whole.lost();
  const auto stampOf = [&](std::size_t row) { return whole.rows()[row].stamp; };
  const Duration longest = fromSeconds(seconds);
  const Duration span = stampOf(scans.size() - 1) - stampOf(0) - longest;
  for (int place = 0; place < places; ++place) {
    const Timestamp begin = stampOf(0) + place * span / places;
    std::size_t row = 0;
    while (stampOf(row) < begin) ++row;
    Robot robot(config, map);
    ColdStart start{.begin = toSeconds(begin - stampOf(0))};
    for (std::size_t i = scans[row]; i < samples.size() && row < scans.size(); ++i) {
      if (stampOf(row) - begin > longest) break;
      robot.add(samples[i]);
      if (i != scans[row]) continue;
      if (robot.placed()) {
        const Pose2 error = between(whole.rows()[row].T_map_base, robot.rows().back().T_map_base);
        start.found = true;
        start.after = toSeconds(stampOf(row) - begin);
        start.translation = std::hypot(error.x, error.y);
        start.rotation = std::abs(error.theta) * 180.0 / std::numbers::pi;
        break;
      }
      ++row;
    }
    const bool right = start.translation < kRightDistance && start.rotation < kRightRotation;
    ++(!start.found ? report.not_yet : right ? report.right : report.wrong);
    report.starts.push_back(start);
    const auto& times = robot.searchMilliseconds();
    report.search_ms.insert(report.search_ms.end(), times.begin(), times.end());
  }
  return report;
}

}  // namespace slam
