// SPDX-License-Identifier: BSD-3-Clause
#include "app/graph_thread.hpp"

#include <random>
#include <span>
#include <utility>

#include "app/log.hpp"
#include "runtime/clock.hpp"
#include "slam/map_import.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr double kRate = 20.0;        // [Hz] keyframes come at a few per second
constexpr Duration kLoadLimit = 10s;  // a disk that takes longer for the first map is not waited for
constexpr Duration kDiskHangs = 3s;   // in one job
const char* const kNoAnswer = "the disk does not answer; try again when it does";
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
  const auto begun = std::make_shared<MapState>();
  start([this, begun] { *begun = keeper_.begin(monotonicNow()); },
        [this, begun] { begun->keyframes.size() > 0 ? changeTo(std::move(*begun)) : void(); });
  if (disk_.waitUntilIdle(monotonicNow() + kLoadLimit)) {
    then_ = nullptr;
    beginIn(std::move(*begun));
  } else {
    beginIn(MapState());
  }
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
  without_map_ = keeper_.localises() && map.keyframes.size() == 0;
  if (without_map_) start_.in_known_map = true;  // the robot is not found in it
  fitting_ = all_config_;
  fitting_.mode = keeper_.localises() ? "localise" : "slam";
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
  const bool free = diskIsFree();
  if (pending_ && disk_.busyFor(monotonicNow()) > kDiskHangs) refuse(*std::exchange(pending_, std::nullopt), kNoAnswer);
  exchange_.grids.drain([this](const std::shared_ptr<DrawnMap>& drawn) {
    // Where the map has moved since, it is asked for again.
    if (requested_ && requested_->generation == back_end_->generation()) return write(std::move(*drawn));
    if (const auto stale = std::exchange(requested_, std::nullopt)) checkpoint_wanted_ |= stale->wanted;
  });
  if (!free || disk_.isBusy() || requested_) return;
  const Timestamp now = monotonicNow();
  const bool drawn = back_end_->keyframes().size() > 0;
  if (keeper_.retryDue(now)) return lookForMap(now);
  const bool due = keeper_.checkpointDue(now, changes()) || (checkpoint_wanted_ && keeper_.checkpointAllowed(now));
  if (pending_ || (drawn && due)) return requestGrid();
  if (drawn && !checkpoint_wanted_ && keeper_.journalDue(now, last_pose_, changes())) writeJournal(now);
}

void GraphThread::start(std::function<void()> job, std::function<void()> then) {
  then_ = std::move(then);
  disk_.start(std::move(job));
}

/// Does what was to be done behind the last job.
bool GraphThread::diskIsFree() {
  if (disk_.isBusy()) return false;
  if (const auto then = std::exchange(then_, nullptr)) then();
  return true;
}

void GraphThread::write(DrawnMap drawn) {
  const Requested shown = *std::exchange(requested_, std::nullopt);
  const auto map = std::make_shared<const MapState>(mapState(std::move(drawn), shown.keyframes));
  const auto seen = unjournalledViews();
  const auto outcome = std::make_shared<Outcome>();
  const auto command = std::exchange(pending_, std::nullopt);
  obeys_ = command.has_value();
  start(
      [this, map, seen, outcome, command, changes = shown.changes] {
        outcome->saved = keeper_.checkpoint(monotonicNow(), *map, changes, *seen);
        if (command) carryOut(*command, *map, *outcome);
      },
      [this, outcome, shown] {
        if (outcome->saved) {
          new_views_.erase(new_views_.begin(), new_views_.begin() + shown.views);
          journalled_views_ = 0;
        } else {
          checkpoint_wanted_ |= shown.wanted;
        }
        obeys_ = false;
        if (outcome->answer) exchange_.map_answers.tryPush(*outcome->answer);
        if (outcome->next) changeTo(std::move(*outcome->next));
      });
}

void GraphThread::writeJournal(Timestamp now) {
  const auto map =
      std::make_shared<const MapState>(mapState({OccupancyGrid(all_config_.map), {}}, back_end_->keyframes().size()));
  const auto seen = unjournalledViews();
  const auto written = std::make_shared<bool>(false);
  start([this, now, map, seen, written, changes = changes()] { *written = keeper_.journal(now, *map, *seen, changes); },
        [this, written, views = new_views_.size()] {
          if (*written) journalled_views_ = views;
        });
}

void GraphThread::lookForMap(Timestamp now) {
  const auto found = std::make_shared<std::optional<MapState>>();
  start([this, now, found] { *found = keeper_.retry(now); },
        [this, found] {
          if (*found) changeTo(std::move(**found));
        });
}

void GraphThread::changeTo(MapState next) {
  ++map_id_;
  beginIn(std::move(next));
  auto localizer = firstLocalizer();
  if (exchange_.localizers.tryPush(localizer.get())) localizer.release();
}

std::shared_ptr<const std::vector<MapView>> GraphThread::unjournalledViews() const {
  const auto views = std::span(new_views_).subspan(journalled_views_);
  return std::make_shared<const std::vector<MapView>>(views.begin(), views.end());
}

void GraphThread::obey(const MapCommand& command) {
  const bool writes = keeper_.writes();
  std::string problem;
  if (pending_ || obeys_) problem = "another command about the map is being carried out";
  if (disk_.busyFor(monotonicNow()) > kDiskHangs) problem = kNoAnswer;
  if (command.kind == MapCommand::kSave && !writes) {
    problem = keeper_.localises() ? "mode is \"localise\": the map does not change"
                                  : "store.directory is not set in the configuration";
  }
  if (command.kind == MapCommand::kSave && !command.name.empty() && !MapStore::isName(command.name)) {
    problem = "\"" + command.name + "\" is no name of a map; use letters, digits, - and _";
  }
  if (command.kind == MapCommand::kReset && keeper_.localises()) {
    problem = "mode is \"localise\": the map stays; use set-pose to say where the robot is";
  }
  const bool localise = command.kind == MapCommand::kLocalise;
  if ((localise || command.kind == MapCommand::kSlam) && localise == keeper_.localises()) {
    problem = std::string("mode is \"") + (localise ? "localise" : "slam") + "\" already";
  }
  if (!problem.empty()) return refuse(command, problem);
  pending_ = command;  // the present map is stored first
}

void GraphThread::refuse(const MapCommand& command, const std::string& problem) {
  exchange_.map_answers.tryPush({command.id, false, problem});
}

/// In the disk's thread, behind the checkpoint of the present map.
void GraphThread::carryOut(const MapCommand& command, const MapState& map, Outcome& outcome) {
  const std::string loss = "not stored: " + keeper_.problem();
  const auto answer = [&](bool accepted, const std::string& message) {
    outcome.answer = {command.id, accepted, message};
  };
  try {
    if (command.kind == MapCommand::kSave) {
      if (command.name.empty() || command.name == keeper_.name()) {
        return outcome.saved ? answer(true, "saved as " + keeper_.name()) : answer(false, loss);
      }
      keeper_.saveAs(command.name, map);
      return answer(true, "saved as " + command.name);
    }
    const bool lost = !outcome.saved && keeper_.writes() && map.keyframes.size() > 0;
    const std::string before = lost ? "; the one before is " + loss : "";
    if (command.kind == MapCommand::kLoad) {
      outcome.next = keeper_.load(command.name, monotonicNow());
      answer(true, "loaded " + command.name + "; looking for the robot in it" + before);
    } else if (command.kind == MapCommand::kLocalise || command.kind == MapCommand::kSlam) {
      const bool localise = command.kind == MapCommand::kLocalise;
      if (lost) return answer(false, "the map is " + loss);  // the stored one lacks what is new
      outcome.next = keeper_.changeMode(localise, monotonicNow());
      const std::string& name = keeper_.name();
      answer(true, (localise ? "localises in " + name + ", which stays as it is" : "extends " + name) +
                       "; the next start takes mode from the configuration");
    } else {
      keeper_.beginNew(monotonicNow());
      outcome.next.emplace();
      answer(true, "a new map begins" + before);
    }
  } catch (const std::exception& error) {
    answer(false, error.what());
  }
}

void GraphThread::requestGrid() {
  requested_ = {back_end_->keyframes().size(), back_end_->generation(), std::ssize(new_views_), changes(),
                std::exchange(checkpoint_wanted_, false)};
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

void GraphThread::store(DrawnMap drawn) {
  if (!keeper_.writes() || back_end_->keyframes().size() == 0) return;
  exchange_.pose_for_graph.load(snapshot_);
  const auto map = std::make_shared<const MapState>(mapState(std::move(drawn), back_end_->keyframes().size()));
  // Behind a journal that is being written these views may be in it already: twice does no harm.
  const auto seen = unjournalledViews();
  const auto outcome = std::make_shared<Outcome>();
  stored_ = outcome;
  disk_.start([this, map, seen, outcome, changes = changes()] {
    const Timestamp now = monotonicNow();
    if (keeper_.retryDue(now)) keeper_.retry(now);
    outcome->saved = keeper_.checkpoint(now, *map, changes, *seen);
  });
}

bool GraphThread::waitUntilStored(Timestamp deadline) {
  return disk_.waitUntilIdle(deadline) && (!stored_ || stored_->saved);
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
  if (keyframe.map_id != map_id_ || without_map_) return;  // of the map before, or nothing to find it in
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
  checkpoint_wanted_ |= anew && keeper_.writes();
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
