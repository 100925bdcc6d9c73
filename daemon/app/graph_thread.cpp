// SPDX-License-Identifier: BSD-3-Clause
#include "app/graph_thread.hpp"

#include <random>
#include <utility>

#include "app/log.hpp"
#include "runtime/clock.hpp"
#include "slam/map_import.hpp"

namespace slam {
namespace {

constexpr double kRate = 20.0;  // [Hz] keyframes come at a few per second
constexpr int kViewsWritten = static_cast<int>(ViewMemoryConfig{}.per_keyframe);  // into the journal, for a keyframe

/// Another one after each start, so that nobody takes a new map's tiles for those of the map before. Not from the
/// clock: a robot without one may start twice at the same time.
std::int32_t firstMapId() { return static_cast<std::int32_t>(std::random_device{}() & 0x3FFFFFFFU); }

}  // namespace

GraphThread::GraphThread(const Config& config, Exchange& exchange, const WallClock& clock)
    : all_config_(config),
      exchange_(exchange),
      clock_(clock),
      keeper_(config),
      map_id_(firstMapId()),
      worker_({.name = "graph", .rate = kRate}, [this] { tick(); }) {
  beginIn(keeper_.begin());
}

GraphThread::~GraphThread() {
  worker_.stop();
  for (auto* queue : {&exchange_.corrections, &exchange_.used_corrections}) {
    queue->drain([](MapCorrection* correction) { delete correction; });
  }
  for (auto* queue : {&exchange_.localizers, &exchange_.used_localizers}) {
    queue->drain([](Localizer* localizer) { delete localizer; });
  }
}

void GraphThread::beginIn(MapState map) {
  start_ = startIn(map, map_id_);
  fitting_ = all_config_;
  if (map.picture_only) {
    fitting_.localizer.match = matchInPicture(fitting_.localizer.match, map.grid.resolution());
  }
  config_ = backEndConfig(fitting_);
  last_pose_ = map.T_map_base;
  gyro_bias_ = map.gyro_bias;
  back_end_ = std::make_unique<BackEnd>(config_);
  back_end_->load(map.keyframes, map.in_map);
  generation_ = 0;
  correction_away_ = false;
  requested_.reset();
  new_views_.clear();
  journalled_views_ = 0;
  views_kept_.clear();
  views_ = 0;
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = monotonicNow();
  change->begin_in = std::make_shared<const MapState>(std::move(map));
  changes_.push_back(std::move(change));
}

std::unique_ptr<Localizer> GraphThread::firstLocalizer() const {
  return std::make_unique<Localizer>(localizerConfig(fitting_), &monotonicNow, start_);
}

void GraphThread::tick() {
  exchange_.used_localizers.drain([](Localizer* used) { delete used; });
  exchange_.used_corrections.drain([this](MapCorrection* used) {
    std::unique_ptr<MapCorrection> correction(used);
    if (correction->map_id != map_id_) return;
    back_end_->recycle(std::move(correction));
    correction_away_ = false;
  });
  takeIn();
  exchange_.map_commands.drain([this](const MapCommand& command) { obey(command); });
  keepMap();
  sendChanges();
}

void GraphThread::keepMap() {
  if (exchange_.pose_for_graph.load(snapshot_) && snapshot_.map_id == map_id_) {
    gyro_bias_ = snapshot_.odometry.gyro_bias;
    const LocalisationState state = snapshot_.pose.state;
    if (state == LocalisationState::kLocalised) last_pose_ = snapshot_.pose.T_map_base;
  }
  const Timestamp now = monotonicNow();
  exchange_.grids.drain([&](const std::shared_ptr<DrawnMap>& drawn) {
    if (!requested_) return;
    const Requested shown = *std::exchange(requested_, std::nullopt);
    if (shown.generation != back_end_->generation()) return requestGrid();  // the map has moved since
    const MapState map = mapState(std::move(*drawn), shown.keyframes);
    const bool saved = keeper_.checkpoint(now, map, shown.changes, unjournalledViews());
    if (saved) {
      new_views_.erase(new_views_.begin(), new_views_.begin() + shown.views);
      journalled_views_ = 0;
    }
    if (!pending_) return;
    const MapCommand command = *std::exchange(pending_, std::nullopt);
    if (command.kind == MapCommand::kSave && command.name.empty()) {
      exchange_.map_answers.tryPush(
          {command.id, saved, saved ? "saved as " + keeper_.name() : "not saved; the log says why"});
    } else {
      carryOut(command, map);
    }
  });
  if (back_end_->keyframes().size() == 0) return;
  if (keeper_.checkpointDue(now, changes())) requestGrid();
  if (keeper_.journalDue(now, last_pose_, changes())) {
    const MapState map = mapState({OccupancyGrid(all_config_.map), {}}, back_end_->keyframes().size());
    if (keeper_.journal(now, map, unjournalledViews(), changes())) journalled_views_ = new_views_.size();
  }
}

std::span<const MapView> GraphThread::unjournalledViews() const {
  return std::span(new_views_).subspan(journalled_views_);
}

void GraphThread::obey(const MapCommand& command) {
  const bool writes = keeper_.writes();
  std::string problem;
  if (pending_) problem = "another command about the map is being carried out";
  if (command.kind == MapCommand::kSave && !writes) {
    problem = all_config_.mode == "localise" ? "mode is \"localise\": the map does not change"
                                             : "store.directory is not set in the configuration";
  }
  if (command.kind == MapCommand::kSave && !command.name.empty() && !MapStore::isName(command.name)) {
    problem = "\"" + command.name + "\" is no name of a map; use letters, digits, - and _";
  }
  if (command.kind == MapCommand::kReset && all_config_.mode == "localise") {
    problem = "mode is \"localise\": the map stays; use set-pose to say where the robot is";
  }
  if (!problem.empty()) {
    exchange_.map_answers.tryPush({command.id, false, problem});
    return;
  }
  pending_ = command;  // the present map is stored first
  requestGrid();
}

void GraphThread::carryOut(const MapCommand& command, const MapState& map) {
  try {
    if (command.kind == MapCommand::kSave) {
      keeper_.saveAs(command.name, map);
      exchange_.map_answers.tryPush({command.id, true, "saved as " + command.name});
      return;
    }
    MapState next;
    if (command.kind == MapCommand::kLoad) {
      next = keeper_.load(command.name);
    } else {
      keeper_.beginNew();
    }
    ++map_id_;
    beginIn(std::move(next));
    auto localizer = firstLocalizer();
    if (exchange_.localizers.tryPush(localizer.get())) localizer.release();
    exchange_.map_answers.tryPush({command.id, true,
                                   command.kind == MapCommand::kReset
                                       ? "a new map begins"
                                       : "loaded " + command.name + "; looking for the robot in it"});
  } catch (const std::exception& error) {
    exchange_.map_answers.tryPush({command.id, false, error.what()});
  }
}

void GraphThread::requestGrid() {
  if (requested_) return;
  requested_ = {back_end_->keyframes().size(), back_end_->generation(), std::ssize(new_views_), changes()};
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = monotonicNow();
  change->send_grid = true;
  changes_.push_back(std::move(change));
}

MapState GraphThread::mapState(DrawnMap drawn, int drawn_keyframes) const {
  MapState map;
  map.keyframes = back_end_->keyframes();
  map.in_map = back_end_->inMap();
  map.grid = std::move(drawn.grid);
  map.views = std::move(drawn.views);
  map.grid_keyframes = drawn_keyframes;
  map.T_map_base = last_pose_;
  map.gyro_bias = gyro_bias_;
  map.T_base_lidar = all_config_.localizer.lidar.T_base_lidar;
  map.range_max = all_config_.localizer.lidar.range_max;
  map.utime = clock_.utime(monotonicNow());
  return map;
}

/// Counts up with whatever the stored map should show.
std::int64_t GraphThread::changes() const {
  return static_cast<std::int64_t>(back_end_->keyframes().size()) + back_end_->generation() + views_;
}

bool GraphThread::store(DrawnMap drawn) {
  if (!keeper_.writes() || back_end_->keyframes().size() == 0) return true;
  exchange_.pose_for_graph.load(snapshot_);
  const int keyframes = back_end_->keyframes().size();
  return keeper_.checkpoint(monotonicNow(), mapState(std::move(drawn), keyframes), changes(), unjournalledViews());
}

void GraphThread::takeIn() {
  // Sights first: the keyframe that one was seen near is in the other queue by then.
  sights_.clear();
  exchange_.sights.drain([this](const DepthSight& sight) { sights_.push_back(sight); });
  exchange_.keyframes.drain([this](const Keyframe& keyframe) { add(keyframe); });
  for (const DepthSight& sight : sights_) add(sight);
}

void GraphThread::add(const DepthSight& sight) {
  if (sight.map_id != map_id_) return;
  const auto view = back_end_->mapView(sight);
  if (!view) return;
  if (keeper_.writes() && ++views_kept_[view->keyframe] <= kViewsWritten) {
    new_views_.push_back(*view);
    ++views_;
  }
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = sight.laser.stamp;
  change->views.push_back(*view);
  changes_.push_back(std::move(change));
}

void GraphThread::add(const Keyframe& keyframe) {
  if (keyframe.map_id != map_id_) return;  // of the map before
  const Timestamp begin = monotonicNow();
  const BackEndCounters before = back_end_->counters();
  back_end_->add(keyframe, !correction_away_);
  const bool anew = back_end_->counters().begun_anew > before.begun_anew;
  if (back_end_->counters().placed > before.placed) {
    ++exchange_.relocalised;
    logInfo("found in the map");
  }
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = keyframe.stamp;
  if (anew) {
    ++exchange_.maps_begun_anew;
    logWarning("the map begins anew: what came before the robot was lost is too little to be found in");
  }
  change->first_in_map = back_end_->firstInMap();
  change->scans = back_end_->mapScans(keyframe);
  if (generation_ != back_end_->generation()) {
    const BackEndCounters& counters = back_end_->counters();
    exchange_.optimise.add(monotonicNow() - begin);
    exchange_.loop_closures = counters.loop_closures;
    exchange_.revoked_closures = counters.revoked;
    generation_ = back_end_->generation();
    const auto poses = back_end_->keyframes().graph().poses();
    change->poses.assign(poses.begin(), poses.end());
    if (counters.loop_closures > before.loop_closures) {
      logInfo("loop closed: " + std::to_string(counters.loop_closures) + " closures join " +
              std::to_string(counters.keyframes) + " keyframes");
    }
  }
  changes_.push_back(std::move(change));
  if (anew && keeper_.writes()) requestGrid();  // the journal cannot say it
  if (auto correction = back_end_->takeCorrection()) {
    correction->map_id = map_id_;
    correction_away_ = exchange_.corrections.tryPush(correction.get());
    correction_away_ ? static_cast<void>(correction.release()) : back_end_->recycle(std::move(correction));
  }
}

void GraphThread::sendChanges() {
  while (!changes_.empty() && exchange_.map_changes.hasRoom()) {
    exchange_.map_changes.tryPush(changes_.front());
    changes_.pop_front();
  }
}

void GraphThread::finish() {
  takeIn();
  sendChanges();
}

}  // namespace slam
