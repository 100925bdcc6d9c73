// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/graph_work.hpp"

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "app/log/log.hpp"
#include "app/map/edit_messages.hpp"
#include "problems/daemon.hpp"
#include "slam/pipeline.hpp"

namespace slam {
namespace {

/// Another one after each start, so that nobody takes a new map's tiles for those of the map before. Not from the
/// clock: a robot without one may start twice at the same time.
std::int32_t firstMapId() { return static_cast<std::int32_t>(std::random_device{}() & 0x3FFFFFFFU); }

}  // namespace

GraphWork::GraphWork(const Config& config, const GraphEnds& ends, const WallClock& clock, StorePolicy& policy)
    : config_(config), ends_(ends), clock_(clock), policy_(policy), start_{.map_id = firstMapId()} {}

void GraphWork::beginIn(MapState map, bool localise) {
  start_ = startIn(map, start_.map_id + 1);
  search_.without_map = localise && map.keyframes.size() == 0;
  if (search_.without_map) start_.in_known_map = true;  // the robot is not found in it
  Config config = config_;
  config.mode = localise ? RunMode::kLocalise : RunMode::kSlam;
  const PipelineConfig fitting = fitted({frontEndConfig(config), backEndConfig(config), config.map}, map);
  front_end_config_ = fitting.front_end;
  robot_.T_map_base = map.T_map_base;
  robot_.gyro_bias = map.gyro_bias;
  if (robot_.body.degrees() == 0) robot_.body = map.body;  // it is the robot's, whatever the map
  start_.body = robot_.body;
  if (builder_) {
    earlier_.placed += backEnd().counters().placed;
    earlier_.begun_anew += backEnd().counters().begun_anew;
  }
  builder_ = std::make_unique<MapBuilder>(fitting.back_end, map, &monotonicNow);
  addChange(monotonicNow()).begin_in = std::make_shared<const MapState>(std::move(map));
  search_.floor.reset();
  search_.doubt.store({});
  showEdits();
}

void GraphWork::showEdits() {
  edits_ = std::make_shared<const std::vector<map_edit_t>>(editMessages(backEnd().map(), start_.map_id));
}

std::unique_ptr<FrontEnd> GraphWork::newFrontEnd() const {
  auto front_end = std::make_unique<FrontEnd>(front_end_config_, &monotonicNow, start_);
  if (config_.runtime.realtime) front_end->takeMemory();
  return front_end;
}

void GraphWork::tick() {
  ends_.front_end.used_front_ends.drain([](FrontEnd* used) { delete used; });
  ends_.front_end.used_corrections.drain([this](MapCorrection* used) {
    std::unique_ptr<MapCorrection> correction(used);
    if (correction->map_id == start_.map_id) builder_->recycle(std::move(correction));
  });
  takeIn();
  followPose();
}

void GraphWork::takeIn() {
  // Sights first: the keyframe that one was seen near is in the other queue by then.
  std::vector<DepthObservation> sights;
  ends_.front_end.sights.drain([&](const DepthObservation& sight) { sights.push_back(sight); });
  ends_.front_end.keyframes.drain([this](const Keyframe& keyframe) { add(keyframe); });
  for (const DepthObservation& sight : sights) add(sight);
}

void GraphWork::followPose() {
  if (!ends_.pose.load(snapshot_) || snapshot_.map_id != start_.map_id) return;
  robot_.gyro_bias = snapshot_.odometry.gyro_bias;
  builder_->allowFor(snapshot_.scans - std::exchange(seen_scans_, snapshot_.scans));
  robot_.body = snapshot_.body;
  if (snapshot_.pose.state == LocalisationState::kLocalised) robot_.T_map_base = snapshot_.pose.T_map_base;
}

MapChange& GraphWork::addChange(Timestamp stamp) {
  const auto& change = changes_.emplace_back(std::make_shared<MapChange>());
  change->map_id = start_.map_id;
  change->stamp = stamp;
  return *change;
}

void GraphWork::requestGrid() { addChange(monotonicNow()).send_grid = true; }

void GraphWork::add(const DepthObservation& sight) {
  if (sight.map_id != start_.map_id) return;
  const auto view = builder_->add(sight);
  if (!view) return;
  policy_.add(*view);
  addChange(sight.laser.stamp).views.push_back(*view);
}

void GraphWork::add(const Keyframe& keyframe) {
  if (keyframe.map_id != start_.map_id || search_.without_map) return;  // of the map before, or nothing to find it in
  MapUpdate update = builder_->add(keyframe);
  BackEndCounters counters = backEnd().counters();
  logEvents(update, counters);
  followFloor(update);
  if (!update.poses.empty()) ends_.loop_closure.add(update.work);
  counters.placed += earlier_.placed;
  counters.begun_anew += earlier_.begun_anew;
  ends_.counters.store(counters);
  MapChange& change = addChange(keyframe.stamp);
  change.first_in_map = update.first_in_map;
  change.scans = std::move(update.scans);
  change.poses = std::move(update.poses);
  change.edits = std::move(update.edits);
  if (change.edits) showEdits();
  if (update.begun_anew) policy_.requireCheckpoint();
  if (update.correction) send(std::move(update.correction));
}

void GraphWork::followFloor(const MapUpdate& update) {
  if (update.elsewhere) search_.floor = std::make_shared<const FloorFound>(*update.elsewhere);
  const std::vector<FloorFound> floors = backEnd().floorDoubt();
  std::string others;
  for (std::size_t i = 2; i < floors.size(); ++i) others += ", " + floors[i].name;
  search_.doubt.store(floors.size() < 2 ? Problem()
                                        : Problem(problem::kFloorsAlike, {}, {floors[0].name, floors[1].name, others}));
}

std::optional<Pose2> GraphWork::placeIn(const std::string& map) const {
  for (const FloorFound& floor : backEnd().floorDoubt()) {
    if (floor.name == map && isInSession(floor)) return floor.T_floor_session * trackedPose();
  }
  return std::nullopt;
}

std::shared_ptr<const FloorFound> GraphWork::takeFloor() {
  auto floor = std::exchange(search_.floor, nullptr);
  return floor && isInSession(*floor) ? floor : nullptr;
}

void GraphWork::logEvents(const MapUpdate& update, const BackEndCounters& counters) {
  const auto report = [&](const char* cause, const std::string& text, LogLine::Level level) {
    if (const auto line = log_.happened(cause, {}, text, level, monotonicNow())) logLine(*line);
  };
  if (update.relocalised) report("found", "found in the map", LogLine::kInfo);
  if (update.taken_back) {
    report(
        "taken back",
        "the robot got lost soon after it was found: what it saw on the way is left out of the map, which is as before",
        LogLine::kWarning);
  }
  if (update.begun_anew) {
    report("anew", "the map begins anew: what came before the robot was lost is too little to be found in",
           LogLine::kWarning);
  }
  if (update.loop_closed) {
    report("loop",
           "loop closed: " + std::to_string(counters.loop_closures) + " closures join " +
               std::to_string(counters.keyframes) + " keyframes",
           LogLine::kInfo);
  }
}

void GraphWork::send(std::unique_ptr<MapCorrection> correction) {
  correction->map_id = start_.map_id;
  if (config_.runtime.realtime) correction->reference.takeMemory();
  const bool sent = ends_.front_end.corrections.tryPush(correction.get());
  sent ? static_cast<void>(correction.release()) : builder_->recycle(std::move(correction));
}

void GraphWork::sendChanges() {
  while (!changes_.empty() && ends_.map.changes.hasRoom()) {
    ends_.map.changes.tryPush(changes_.front());
    changes_.pop_front();
  }
  if (edits_ && ends_.edits.hasRoom()) ends_.edits.tryPush(std::exchange(edits_, nullptr));
}

Problem GraphWork::edit(EditCommand command, int* done) {
  const Timestamp now = monotonicNow();
  command.utime = clock_.utime(now);
  EditRequest& request = command.request;
  if (request.kind == EditKind::kPlace && request.points.empty()) {
    request.points = {robot_.T_map_base.translation()};
    request.theta = robot_.T_map_base.theta;
  }
  EditOutcome outcome = builder_->edit(command, robot_.T_map_base.translation());
  if (outcome.problem) return outcome.problem;
  MapChange& change = addChange(now);
  change.scans = std::move(outcome.scans);
  change.edits = std::move(outcome.drawing);
  change.anew = std::move(outcome.anew);
  showEdits();
  *done = outcome.edit;
  return {};
}

std::int64_t GraphWork::changes() const {
  return static_cast<std::int64_t>(backEnd().keyframes().size()) + backEnd().generation() + policy_.views().added() +
         backEnd().map().edits.revision;
}

MapState GraphWork::state(DrawnMap drawn, int drawn_keyframes) const {
  MapState map = builder_->state(std::move(drawn), drawn_keyframes);
  map.T_map_base = robot_.T_map_base;
  map.gyro_bias = robot_.gyro_bias;
  map.body = robot_.body;
  map.T_base_lidar = config_.front_end.lidar.T_base_lidar;
  map.range_max = config_.front_end.lidar.range_max;
  map.utime = clock_.utime(monotonicNow());
  return map;
}

}  // namespace slam
