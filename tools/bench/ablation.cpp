// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/ablation.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <fstream>
#include <limits>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "config/loader.hpp"
#include "mapping/map_files.hpp"
#include "slam/map_import.hpp"
#include "tools/bench/cold_starts.hpp"
#include "tools/eval/overlay.hpp"
#include "tools/eval/trust.hpp"
#include "tools/replay/estimates.hpp"

namespace slam {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr int kOften = std::numeric_limits<int>::max() / 2;
constexpr double kLongSilence = 1e6;  // [s]

const std::array kRules = std::to_array<Rule>({
    {"1 stamp far ahead waits", [](FrontEndConfig& c) { c.intake.stamps.far_ahead = kNever; }},
    {"2 stamps grow by a quarter interval", [](FrontEndConfig& c) { c.intake.stamps.least_step = 0.0; }},
    {"2, 3 clock set back", [](FrontEndConfig& c) { c.intake.stamps.set_back = kNever; }},
    {"4 lidar stuck", [](FrontEndConfig& c) { c.intake.repeats.stuck_turns = kOften; }},
    {"5 scan is a copy", [](FrontEndConfig& c) { c.intake.fastest_turn = c.intake.soonest_scan = 0.0; }},
    {"6 stuck counts only while moving",
     [](FrontEndConfig& c) { c.intake.moving_speed = c.intake.moving_turn = -1.0; }},
    {"6b ranges that scatter at rest", [](FrontEndConfig& c) { c.preprocessor.interpreter.range_noise.most = kNever; }},
    {"8 points to mid-sweep", [](FrontEndConfig& c) { c.preprocessor.scan_moment = 0.0; }},
    {"9 beam spacing", [](FrontEndConfig& c) { c.preprocessor.normals.fine_spacing = kNever; }},
    {"10 grazing points slide", [](FrontEndConfig& c) { c.preprocessor.normals.in_a_row = 0.0; }},
    {"10a points seen through", [](FrontEndConfig& c) { c.preprocessor.dynamic_points.most = 0.0; }},
    {"10b the bearings' error", [](FrontEndConfig& c) { c.preprocessor.normals.bearing_sigma = 0.0; }},
    {"11 wheels judged", [](FrontEndConfig& c) { c.wheel_monitor.memory = kNever; }},
    {"11a wheels withdrawn", [](FrontEndConfig& c) { c.wheel_monitor.contradiction = kNever; }},
    {"11c wheels consistent", [](FrontEndConfig& c) { c.wheel_monitor.consistency = kNever; }},
    {"12 wheels' scale", [](FrontEndConfig& c) { c.wheel_monitor.scale.significance = kNever; }},
    {"13 slip", [](FrontEndConfig& c) { c.ekf.slip_angle = kNever; }},
    {"14 standstill",
     [](FrontEndConfig& c) { c.ekf.standstill.min_time = c.ekf.standstill.min_time_unbiased = kNever; }},
    {"14a sooner without bias",
     [](FrontEndConfig& c) { c.ekf.standstill.min_time_unbiased = c.ekf.standstill.min_time; }},
    {"14b never with silent wheels",
     [](FrontEndConfig& c) { c.ekf.short_silence = c.ekf.long_silence = kLongSilence; }},
    {"15 sudden speeds believed", [](FrontEndConfig& c) { c.ekf.accepts_sudden_speeds = false; }},
    {"16a short intervals joined", [](FrontEndConfig& c) { c.timeline.too_soon = 0.0; }},
    {"16b mean of 0.1 s holds", [](FrontEndConfig& c) { c.timeline.recent = 0.0; }},
    {"17 doubt", [](FrontEndConfig& c) { c.ekf.max_contradiction = 1.0; }},
    {"18 other starting poses", [](FrontEndConfig& c) { c.registration.starts = 1; }},
    {"18a none after a loss of overlap", [](FrontEndConfig& c) { c.registration.sudden_loss = kNever; }},
    {"18c the wheels' turn", [](FrontEndConfig& c) { c.registration.starts = 3; }},
    {"19a gate narrows", [](FrontEndConfig& c) { c.match.initial_pair_distance = c.match.final_pair_distance; }},
    {"19b oscillation damped", [](FrontEndConfig& c) { c.match.damping = 1.0; }},
    {"20a least share of information", [](FrontEndConfig& c) { c.match.min_information = 0.0; }},
    {"20b confirmed share", [](FrontEndConfig& c) { c.match.min_confirmed = 0.0; }},
    {"20c tension between a scan's parts",
     [](FrontEndConfig& c) { c.match.part_gap = kNever, c.match.part_bend = -2.0; }},
    {"21 low overlap", [](FrontEndConfig& c) { c.match.min_overlap = 0.0; }},
    {"21a few pairs", [](FrontEndConfig& c) { c.match.min_pairs = 3; }},
    {"22 something moving pulls", [](FrontEndConfig& c) { c.dynamic_object_gate.noticeable = kNever; }},
    {"22a wheels slipped", [](FrontEndConfig& c) { c.wheel_monitor.slip = kNever; }},
    {"27b two places", [](FrontEndConfig& c) { c.search.distinct_distance = c.search.distinct_rotation = kNever; }},
    {"24a a find's overlap", [](FrontEndConfig& c) { c.validator.trusted_overlap = 0.0; }},
    {"24b, 28a sees through walls", [](FrontEndConfig& c) { c.validator.free_space_violation = kNever; }},
    {"24c a find much worse", [](FrontEndConfig& c) { c.validator.much_worse = kNever; }},
    {"24d a find the gyro contradicts", [](FrontEndConfig& c) { c.validator.gyro_error = kNever; }},
    {"26 innovation gate", [](FrontEndConfig& c) { c.ekf.max_rejected_poses = -1; }},
    {"26a third refusal believed", [](FrontEndConfig& c) { c.ekf.max_rejected_poses = kOften; }},
    {"26d rejections that agree", [](FrontEndConfig& c) { c.ekf.same_error = kNever; }},
    {"26b no farther than 1 km", [](FrontEndConfig& c) { c.ekf.farthest_pose = kNever; }},
    {"27 search", [](FrontEndConfig& c) { c.validator.trusted_overlap = 2.0; }},
    {"27a window grows", [](FrontEndConfig& c) { c.registration.widening = 0.0; }},
    {"27b ambiguous", [](FrontEndConfig& c) { c.search.ambiguity = kNever; }},
    {"27d slide", [](FrontEndConfig& c) { c.search.clear_gain = 2.0F; }},
    {"28 failures make a keyframe", [](FrontEndConfig& c) { c.tracking.degraded_after = kLongSilence; }},
    {"28b scans against odometry", [](FrontEndConfig& c) { c.scan_monitor.contradiction = kNever; }},
    {"28c scans against a gyro that rested", [](FrontEndConfig& c) { c.heading_monitor.contradiction = kNever; }},
    {"28d walls in the open", [](FrontEndConfig& c) { c.validator.walls_in_the_open = kNever; }},
    {"29 moves as the nearest", [](FrontEndConfig& c) { c.follows_nearest = false; }},
});

using Measure = AblationCase::Measure;
struct MeasureName {
  std::string_view name;
  Measure measure;
};
constexpr std::array kMeasures = std::to_array<MeasureName>({{"relations", Measure::kRelations},
                                                             {"course", Measure::kCourse},
                                                             {"truth", Measure::kTruth},
                                                             {"known", Measure::kKnown},
                                                             {"overlay", Measure::kOverlay},
                                                             {"cold-starts", Measure::kColdStarts},
                                                             {"none", Measure::kNone}});

template <typename Named>
const Named& byName(std::span<const Named> all, std::string_view name, std::string_view what) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  if (found != all.end()) return *found;
  std::string known;
  for (const Named& one : all) known += (known.empty() ? "" : ", ") + std::string(one.name);
  throw std::invalid_argument(std::string(what) + " " + std::string(name) + " is not known; known are " + known);
}

/// A line's cells, without the blanks around them.
std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, '|');) {
    const auto first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

AblationCase readCase(const std::string& line) {
  const std::vector<std::string> cells = cellsOf(line);
  if (cells.size() != 7) throw std::invalid_argument("not NAME | MEASURE | CONFIG | LOG | TRUTH | FAULT | SETTINGS");
  AblationCase one;
  one.name = cells[0];
  one.measure = byName(std::span<const MeasureName>(kMeasures), cells[1], "measure").measure;
  std::vector<std::string> settings;
  std::istringstream words(cells[6]);
  for (std::string setting; words >> setting;) settings.push_back(setting);
  one.config = loadConfig(cells[2], settings);
  one.log = cells[3];
  one.samples = readSamples(one.log);
  if (one.config.base_device.driver == BaseDriver::kNone) {
    std::erase_if(one.samples, [](const LogSample& s) { return std::holds_alternative<WheelSample>(s); });
  }
  if (one.config.imu_device.driver == ImuDriver::kNone) {
    std::erase_if(one.samples, [](const LogSample& s) { return std::holds_alternative<ImuSample>(s); });
  }
  if (one.measure == Measure::kRelations) one.relations = readRelations(cells[4]);
  if (one.measure == Measure::kCourse || one.measure == Measure::kTruth || one.measure == Measure::kKnown) {
    one.truth = readTrajectory(cells[4]);
  }
  if (one.measure == Measure::kColdStarts) {
    one.config.mode = RunMode::kLocalise;
    one.map = importMap(readMapFiles(cells[4]));
    one.places = fitLog(one.samples, one.config, one.map);
  }
  const StreamFault& fault = streamFault(cells[5]);
  for (const LogSample& sample : one.samples) {
    if (isScan(sample)) one.stamps.push_back(std::get<std::unique_ptr<LaserScan>>(sample)->stamp);
  }
  if (fault.name == "copies") {
    for (std::size_t i = 0; i < one.stamps.size(); i += 2) {
      one.stamps.insert(one.stamps.begin() + static_cast<std::ptrdiff_t>(i), one.stamps[i]);
    }
  }
  fault.add(one.samples);
  return one;
}

AblationFigures startCold(const AblationCase& which, const Config& config) {
  const ColdStartReport report =
      coldStarts(which.samples, which.places, config, which.map, {.places = 50, .seconds = 10.0});
  const auto all = static_cast<double>(report.starts.size());
  return {{1.0 - report.right / all}, report.not_yet / all, report.wrong / all};
}

struct Row {
  Timestamp stamp;
  AnchoredPose anchored;
};

double rmseOfKnown(const std::vector<KnownPose>& known, const Trajectory& truth) {
  Trajectory localised;
  for (const KnownPose& row : known) {
    if (row.state == LocalisationState::kLocalised) localised.push_back({row.stamp, row.T_map_base});
  }
  return localised.empty() ? kNever : absoluteErrors(localised, truth, false).rmse;
}

}  // namespace

std::span<const Rule> frontEndRules() { return kRules; }

std::vector<AblationCase> readCases(const std::filesystem::path& list) {
  std::ifstream in(list);
  if (!in) throw std::runtime_error(list.string() + ": cannot read");
  std::vector<AblationCase> cases;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    try {
      cases.push_back(readCase(line));
    } catch (const std::exception& error) {
      throw std::runtime_error(list.string() + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  if (cases.empty()) throw std::runtime_error(list.string() + ": no case in it");
  return cases;
}

AblationFigures runCase(const AblationCase& which, const Rule* without) {
  Config config = which.config;
  if (without != nullptr) without->leave_out(config.front_end);
  if (which.measure == Measure::kColdStarts) return startCold(which, config);
  Pipeline pipeline({frontEndConfig(config), backEndConfig(config), config.map, false}, which.map);
  std::vector<Row> rows;
  std::vector<KnownPose> known;
  std::size_t scan = 0;
  pipeline.on_scan = [&](const ScanOutcome& outcome) {
    const ScanEstimate estimate = estimateOf(pipeline.frontEnd(), outcome, 0);
    const Timestamp stamp = which.stamps[scan++];
    rows.push_back({stamp, pipeline.frontEnd().anchor(estimate.T_map_base)});
    known.push_back({stamp, estimate.state, estimate.T_map_base, estimate.covariance});
  };
  for (const LogSample& sample : which.samples) addTo(pipeline, sample);
  Trajectory last;
  Trajectory causal;
  for (const Row& row : rows) {
    const Pose2 T_map_keyframe =
        row.anchored.keyframe < 0 ? Pose2{} : pipeline.backEnd().keyframes().pose(row.anchored.keyframe);
    last.push_back({row.stamp, T_map_keyframe * row.anchored.T_keyframe_base});
  }
  for (const KnownPose& row : known) causal.push_back({row.stamp, row.T_map_base});

  AblationFigures figures;
  const auto localised = static_cast<double>(std::count_if(
      known.begin(), known.end(), [](const KnownPose& row) { return row.state == LocalisationState::kLocalised; }));
  figures.lost = 1.0 - localised / static_cast<double>(std::max<std::size_t>(1, known.size()));
  const auto byStamp = [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; };
  std::stable_sort(last.begin(), last.end(), byStamp);
  std::stable_sort(causal.begin(), causal.end(), byStamp);
  switch (which.measure) {
    case Measure::kRelations:
      for (const Trajectory* poses : {&last, &causal}) {
        figures.errors.push_back(relationErrors(*poses, which.relations).translation.mean);
      }
      break;
    case Measure::kCourse:
      figures.errors = {absoluteErrors(last, which.truth).rmse};
      break;
    case Measure::kTruth:
      figures.errors = {absoluteErrors(last, which.truth).rmse};
      break;
    case Measure::kKnown:
      figures.errors = {rmseOfKnown(known, which.truth)};
      break;
    case Measure::kOverlay:
      try {
        figures.errors = {overlayVisits(last, which.log, which.config).mean};
      } catch (const std::runtime_error&) {
        figures.errors = {kNever};  // the path does not come back
      }
      break;
    case Measure::kNone:
    case Measure::kColdStarts:
      break;
  }
  if (which.measure == Measure::kTruth || which.measure == Measure::kKnown) {
    const TrustOptions options{.align_seconds = 0.0, .settling = 10.0, .kidnapped = {}};
    figures.sure_and_wrong = trustErrors(known, which.truth, options).sureAndWrong();
  }
  return figures;
}

void ablate(std::span<const AblationCase> cases, std::span<const Rule* const> rules, int jobs,
            const std::function<void(const Rule* without, const std::vector<AblationFigures>& of_cases)>& done) {
  const std::size_t rows = rules.size() + 1;
  std::vector<std::vector<AblationFigures>> figures(rows, std::vector<AblationFigures>(cases.size()));
  std::vector<std::size_t> left(rows, cases.size());
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::condition_variable finished;
  const auto ruleOf = [&](std::size_t row) { return row == 0 ? nullptr : rules[row - 1]; };
  std::vector<std::jthread> workers;
  for (int i = 0; i < jobs; ++i) {
    workers.emplace_back([&] {
      for (std::size_t task = next++; task < rows * cases.size(); task = next++) {
        const std::size_t row = task / cases.size(), which = task % cases.size();
        AblationFigures result = runCase(cases[which], ruleOf(row));
        const std::lock_guard lock(mutex);
        figures[row][which] = std::move(result);
        --left[row];
        finished.notify_one();
      }
    });
  }
  for (std::size_t row = 0; row < rows; ++row) {
    std::unique_lock lock(mutex);
    finished.wait(lock, [&] { return left[row] == 0; });
    lock.unlock();
    done(ruleOf(row), figures[row]);
  }
}

}  // namespace slam
