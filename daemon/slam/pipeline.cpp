// SPDX-License-Identifier: BSD-3-Clause
#include "slam/pipeline.hpp"

#include <limits>
#include <utility>

namespace slam {

PipelineConfig fitted(PipelineConfig config, const MapState& map) {
  config.front_end.preprocessor.interpreter.several_floors = !map.floors.others.empty();
  if (map.kind == MapKind::kScans) return config;
  for (MatchConfig* match : {&config.front_end.match, &config.back_end.match})
    match->overlap_distance += 0.5 * map.grid.resolution();  // a wall may lie so far beside its cell's centre
  config.back_end.relocalisation.places.model = floorPlanModel();
  return config;
}

Pipeline::Pipeline(const PipelineConfig& config, const MapState& map, Stopwatch stopwatch)
    : front_end_(std::make_unique<FrontEnd>(fitted(config, map).front_end, stopwatch, startIn(map))),
      probe_(config.front_end),
      builder_(fitted(config, map).back_end, map, stopwatch) {
  if (!config.draws) return;
  mapper_.emplace(config.map);
  if (map.keyframes.size() > 0)
    mapper_->load(scansOf(map), viewsOf(map), map.grid.clone(), map.grid_keyframes, drawingOf(map));
}

void Pipeline::add(const WheelSample& sample) {
  front_end_->add(sample);
  probe_.add(sample);
}

void Pipeline::add(const ImuSample& sample) {
  front_end_->add(sample);
  probe_.add(sample);
}

void Pipeline::add(const PseudoLaser& laser) {
  const DepthObservation* sight = front_end_->add(laser);
  const auto view = sight != nullptr && mapper_ ? builder_.add(*sight) : std::nullopt;
  if (view) mapper_->add(*view);
}

ScanOutcome Pipeline::add(const LaserScan& scan) {
  const ScanOutcome outcome = match(scan);
  if (outcome.keyframe != nullptr) build(*outcome.keyframe);
  correct();
  return outcome;
}

ScanOutcome Pipeline::match(const LaserScan& scan) {
  const ScanOutcome outcome = front_end_->add(scan);
  probe_.add(outcome, front_end_->lidarDelay().used());
  builder_.allowFor(1);
  if (on_scan) on_scan(outcome);
  probe_.work();
  return outcome;
}

void Pipeline::build(const Keyframe& keyframe) {
  MapUpdate update = builder_.add(keyframe);
  if (mapper_) {
    mapper_->forgetBefore(update.first_in_map);
    for (const MapScan& scan : update.scans) mapper_->add(scan);
    if (!update.poses.empty()) mapper_->move(update.poses);  // drawn when somebody looks
    if (update.edits) mapper_->apply(*update.edits);
  }
  if (on_update) on_update(update);
  if (update.correction) correction_ = std::move(update.correction);
}

void Pipeline::correct() {
  if (!correction_) return;
  front_end_->apply(*correction_);
  builder_.recycle(std::move(correction_));
}

Mapper& Pipeline::drawn() {
  mapper_->work(std::numeric_limits<int>::max());
  return *mapper_;
}

MapState Pipeline::state() {
  const Mapper& mapper = drawn();
  MapState map = builder_.state({mapper.grid().clone(), mapper.views()}, backEnd().keyframes().size());
  const Timestamp now = front_end_->newestStamp();
  map.T_map_base = front_end_->estimate(now).T_map_base;
  map.gyro_bias = front_end_->odometry(now).gyro_bias;
  map.body = front_end_->interpreter().body();
  map.T_base_lidar = front_end_->config().lidar.T_base_lidar;
  map.range_max = front_end_->config().lidar.range_max;
  return map;
}

}  // namespace slam
