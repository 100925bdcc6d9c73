// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/which_floor.hpp"

#include <optional>
#include <stdexcept>
#include <variant>

#include "store/floor_maps.hpp"
#include "store/map_store.hpp"
#include "tools/bench/log_truth.hpp"

namespace slam {
namespace {

/// One start, from a sample that is a scan. @param row of it
FloorStart startAt(const std::vector<LogSample>& samples, const LogTruth& truth, std::size_t sample, std::size_t row,
                   const PipelineConfig& robot, const MapState& map, const WhichFloorOptions& options) {
  Pipeline pipeline(robot, map);
  std::optional<FloorFound> elsewhere;
  pipeline.on_update = [&](const MapUpdate& update) {
    if (update.elsewhere) elsewhere = update.elsewhere;
  };
  const Timestamp begin = truth.rows[row].stamp;
  FloorStart start{.begin = toSeconds(begin - truth.rows.front().stamp), .found = {}, .error = {}, .doubt = {}};
  for (std::size_t i = sample; i < samples.size() && row < truth.rows.size(); ++i) {
    const Timestamp now = truth.rows[row].stamp;
    if (toSeconds(now - begin) > options.seconds) break;
    const auto outcome = addTo(pipeline, samples[i]);
    if (!outcome) continue;
    const bool here = pipeline.frontEnd().placed();
    if (here || elsewhere) {
      start.found = here ? options.begin_in : elsewhere->name;
      start.after = toSeconds(now - begin);
      const Pose2 T_map_base = pipeline.frontEnd().estimate(outcome->stamp).T_map_base;
      start.error = errorOf(here ? T_map_base : elsewhere->T_floor_session * T_map_base, truth.rows[row].T_map_base);
      break;
    }
    ++row;
  }
  for (const FloorFound& floor : pipeline.backEnd().floorDoubt()) start.doubt += " " + floor.name;
  return start;
}

}  // namespace

WhichFloorReport whichFloor(const std::filesystem::path& log, const std::filesystem::path& maps, const Config& config,
                            const WhichFloorOptions& options, const std::function<void(int done)>& progress) {
  const std::vector<LogSample> samples = readSamples(log);
  const LogTruth truth = fitLog(samples, config, openMap(maps / options.truth, config.map).state);
  MapState map = openMap(maps / options.begin_in, config.map).state;
  std::vector<std::string> remarks;
  map.floors = loadFloors(maps, options.floors, options.begin_in, config.front_end.lidar, &remarks);
  if (!remarks.empty()) throw std::runtime_error(remarks.front());
  const PipelineConfig robot{frontEndConfig(config), backEndConfig(config), config.map, false};
  std::vector<std::size_t> scans;  // sample of each row
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::holds_alternative<std::unique_ptr<LaserScan>>(samples[i])) scans.push_back(i);
  }
  const Duration span = truth.rows.back().stamp - truth.rows.front().stamp - fromSeconds(options.seconds);
  WhichFloorReport report;
  std::size_t row = 0;
  for (int place = 0; place < options.places; ++place) {
    while (truth.rows[row].stamp < truth.rows.front().stamp + place * span / options.places) ++row;
    const FloorStart start = startAt(samples, truth, scans[row], row, robot, map, options);
    const bool right = start.found == options.truth && start.error.right();
    ++(start.found.empty() ? report.undecided : right ? report.right : report.wrong);
    report.starts.push_back(start);
    if (progress) progress(place + 1);
  }
  return report;
}

}  // namespace slam
