// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/lift_drive.hpp"

#include <memory>
#include <optional>
#include <stdexcept>

#include "store/floor_maps.hpp"
#include "store/map_store.hpp"
#include "tools/bench/log_truth.hpp"

namespace slam {
namespace {

const Eigen::Vector3d kMovedSigma(0.1, 0.1, 0.05);  // [m, m, rad] as slamd begins in a map where it was found

/// A robot that goes on in one map, and changes to another one when it is found there.
class FloorRobot {
 public:
  FloorRobot(const Config& config, const std::filesystem::path& maps, const LiftDriveOptions& options)
      : config_(config), maps_(maps), floors_(options.floors) {
    enter(options.begin_in, std::nullopt);
  }

  std::optional<ScanOutcome> add(const LogSample& sample) {
    const auto outcome = addTo(*pipeline_, sample);
    if (const auto found = std::exchange(elsewhere_, std::nullopt))
      enter(found->name, found->T_floor_session * pipeline_->frontEnd().estimate(outcome->stamp).T_map_base);
    return outcome;
  }
  const std::string& map() const { return map_; }
  const FrontEnd& frontEnd() const { return pipeline_->frontEnd(); }

 private:
  void enter(const std::string& name, const std::optional<Pose2>& T_map_base) {
    MapState map = openMap(maps_ / name, config_.map).state;
    std::vector<std::string> remarks;
    map.floors = loadFloors(maps_, floors_, name, config_.front_end.lidar, &remarks);
    if (!remarks.empty()) throw std::runtime_error(remarks.front());
    if (T_map_base) map.T_map_base = *T_map_base;
    pipeline_ = std::make_unique<Pipeline>(
        PipelineConfig{frontEndConfig(config_), backEndConfig(config_), config_.map, false}, map);
    if (T_map_base) pipeline_->setPose(*T_map_base, kMovedSigma);
    pipeline_->on_update = [this](const MapUpdate& update) {
      if (update.elsewhere) elsewhere_ = update.elsewhere;
    };
    map_ = name;
  }

  Config config_;
  std::filesystem::path maps_;
  std::string floors_, map_;
  std::unique_ptr<Pipeline> pipeline_;
  std::optional<FloorFound> elsewhere_;
};

}  // namespace

LiftDriveReport driveWithLift(const std::filesystem::path& log, const std::filesystem::path& maps, const Config& config,
                              const LiftDriveOptions& options) {
  FloorRobot robot(config, maps, options);
  LiftDriveReport report;
  std::optional<Timestamp> begin, last;
  std::optional<Pose2> at;  // in odom
  bool in_doubt = false, was_placed = true;
  for (const LogSample& sample : readSamples(log)) {
    const auto outcome = robot.add(sample);
    if (!outcome) continue;
    if (!begin) begin = outcome->stamp;
    const double time = toSeconds(outcome->stamp - *begin), step = last ? toSeconds(outcome->stamp - *last) : 0.0;
    last = outcome->stamp;
    report.lasted = time;
    const FrontEnd& front_end = robot.frontEnd();
    const PoseEstimate estimate = front_end.estimate(outcome->stamp);
    const bool sure = estimate.state == LocalisationState::kLocalised;
    const bool doubt = front_end.trackingReport(outcome->stamp).assumed, placed = front_end.placed();
    report.doubts += doubt && !std::exchange(in_doubt, doubt);
    in_doubt = doubt;
    report.lost += !placed && std::exchange(was_placed, placed);
    was_placed = placed;
    report.in_doubt += doubt ? step : 0.0;
    report.unknown +=
        estimate.state == LocalisationState::kLost || estimate.state == LocalisationState::kInitialising ? step : 0.0;
    report.ends_in = robot.map();
    report.ends_sure = sure;
    const bool arrived = time >= options.departs;
    const bool right = robot.map() == (arrived ? options.arrive_in : options.begin_in);
    if (!arrived && report.doubts == 0) report.was_sure = sure && right;
    if (sure && !right) report.wrong_and_sure += step;
    if (!arrived) continue;
    const Pose2 T_odom_base = front_end.odometry(outcome->stamp).T_odom_base;
    if (report.known > time) {
      const double way = at ? between(*at, T_odom_base).translation().norm() : 0.0;
      report.driven += way < 1.0 ? way : 0.0;  // odom begins anew with each map
      if (sure && right) report.known = time - options.departs;
    }
    at = T_odom_base;
  }
  if (!begin) throw std::runtime_error(log.string() + ": no scan in it");
  return report;
}

}  // namespace slam
