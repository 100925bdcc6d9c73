// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/graph_thread.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include "app/log/log.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr double kRate = 20.0;        // [Hz] keyframes come at a few per second
constexpr Duration kLoadLimit = 10s;  // a disk that takes longer for the first map is not waited for
constexpr Duration kDiskHangs = 3s;   // in one job
const char* const kNoAnswer = "the disk does not answer; try again when it does";

/// Another one after each start, so that nobody takes a new map's tiles for those of the map before. Not from the
/// clock: a robot without one may start twice at the same time.
std::int32_t firstMapId() { return static_cast<std::int32_t>(std::random_device{}() & 0x3FFFFFFFU); }

}  // namespace

GraphThread::GraphThread(const Config& config, const GraphEnds& ends, const WallClock& clock)
    : all_config_(config),
      ends_(ends),
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

void GraphThread::beginIn(MapState map) {
  start_ = startIn(map, map_id_);
  without_map_ = keeper_.localises() && map.keyframes.size() == 0;
  if (without_map_) start_.in_known_map = true;  // the robot is not found in it
  Config config = all_config_;
  config.mode = keeper_.localises() ? RunMode::kLocalise : RunMode::kSlam;
  const PipelineConfig fitting = fitted({frontEndConfig(config), backEndConfig(config), config.map}, map);
  front_end_config_ = fitting.front_end;
  last_pose_ = map.T_map_base;
  gyro_bias_ = map.gyro_bias;
  if (body_.degrees() == 0) body_ = map.body;  // it is the robot's, whatever the map
  start_.body = body_;
  if (builder_) {
    placed_before_ += builder_->backEnd().counters().placed;
    begun_anew_before_ += builder_->backEnd().counters().begun_anew;
  }
  builder_ = std::make_unique<MapBuilder>(fitting.back_end, map, &monotonicNow);
  requested_.reset();
  views_.clear();
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = monotonicNow();
  change->begin_in = std::make_shared<const MapState>(std::move(map));
  changes_.push_back(std::move(change));
}

std::unique_ptr<FrontEnd> GraphThread::firstFrontEnd() const {
  auto front_end = std::make_unique<FrontEnd>(front_end_config_, &monotonicNow, start_);
  if (all_config_.runtime.realtime) front_end->takeMemory();
  return front_end;
}

void GraphThread::tick() {
  ends_.front_end.used_front_ends.drain([](FrontEnd* used) { delete used; });
  ends_.front_end.used_corrections.drain([this](MapCorrection* used) {
    std::unique_ptr<MapCorrection> correction(used);
    if (correction->map_id == map_id_) builder_->recycle(std::move(correction));
  });
  takeIn();
  ends_.commands.drain([this](const MapCommand& command) { obey(command); });
  keepMap();
  sendChanges();
}

void GraphThread::keepMap() {
  if (ends_.pose.load(snapshot_) && snapshot_.map_id == map_id_) {
    gyro_bias_ = snapshot_.odometry.gyro_bias;
    builder_->allowFor(snapshot_.scans - std::exchange(seen_scans_, snapshot_.scans));
    body_ = snapshot_.body;
    const LocalisationState state = snapshot_.pose.state;
    if (state == LocalisationState::kLocalised) last_pose_ = snapshot_.pose.T_map_base;
  }
  const bool free = diskIsFree();
  if (disk_.blockedFor(monotonicNow()) > kDiskHangs) {
    if (pending_) refuse(*std::exchange(pending_, std::nullopt), kNoAnswer);
    if (obeyed_ && !obeyed_->taken.test_and_set()) refuse(obeyed_->command, kNoAnswer);
  }
  ends_.map.grids.drain([this](const std::shared_ptr<DrawnMap>& drawn) {
    // Where the map has moved since, it is asked for again.
    if (requested_ && requested_->generation == builder_->backEnd().generation()) return write(std::move(*drawn));
    if (const auto stale = std::exchange(requested_, std::nullopt)) checkpoint_wanted_ |= stale->wanted;
  });
  if (!free || disk_.isBusy() || requested_) return;
  const Timestamp now = monotonicNow();
  const bool drawn = builder_->backEnd().keyframes().size() > 0;
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
  const auto seen = views_.unjournalled();
  const auto outcome = std::make_shared<Outcome>();
  if (pending_) obeyed_ = std::make_shared<Obeyed>(*std::exchange(pending_, std::nullopt));
  start(
      [this, map, seen, outcome, obeyed = obeyed_, changes = shown.changes] {
        outcome->saved = keeper_.checkpoint(monotonicNow(), *map, changes, *seen);
        if (obeyed && !obeyed->taken.test_and_set()) carryOut(obeyed->command, *map, *outcome);
      },
      [this, outcome, shown] {
        if (outcome->saved) {
          views_.setCheckpointed(shown.views);
        } else {
          checkpoint_wanted_ |= shown.wanted;
        }
        obeyed_.reset();
        if (outcome->answer) ends_.answers.tryPush(*outcome->answer);
        if (outcome->next) changeTo(std::move(*outcome->next));
      });
}

void GraphThread::writeJournal(Timestamp now) {
  const auto map = std::make_shared<const MapState>(
      mapState({OccupancyGrid(all_config_.map), {}}, builder_->backEnd().keyframes().size()));
  const auto seen = views_.unjournalled();
  const auto written = std::make_shared<bool>(false);
  start([this, now, map, seen, written, changes = changes()] { *written = keeper_.journal(now, *map, *seen, changes); },
        [this, written, views = views_.size()] {
          if (*written) views_.setJournalled(views);
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
  auto front_end = firstFrontEnd();
  if (ends_.front_end.front_ends.tryPush(front_end.get())) front_end.release();
}

void GraphThread::obey(const MapCommand& command) {
  const bool writes = keeper_.writes();
  std::string problem;
  if (pending_ || obeyed_) problem = "another command about the map is being carried out";
  if (disk_.blockedFor(monotonicNow()) > kDiskHangs) problem = kNoAnswer;
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
  ends_.answers.tryPush({command.id, false, problem});
}

/// In the disk's thread, behind the checkpoint of the present map.
void GraphThread::carryOut(const MapCommand& command, const MapState& map, Outcome& outcome) {
  const std::string loss = "not stored: " + keeper_.problem().words();
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
  requested_ = {builder_->backEnd().keyframes().size(), builder_->backEnd().generation(), views_.size(), changes(),
                std::exchange(checkpoint_wanted_, false)};
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = monotonicNow();
  change->send_grid = true;
  changes_.push_back(std::move(change));
}

MapState GraphThread::mapState(DrawnMap drawn, int drawn_keyframes) const {
  MapState map = builder_->state(std::move(drawn), drawn_keyframes);
  map.T_map_base = last_pose_;
  map.gyro_bias = gyro_bias_;
  map.body = body_;
  map.T_base_lidar = all_config_.front_end.lidar.T_base_lidar;
  map.range_max = all_config_.front_end.lidar.range_max;
  map.utime = clock_.utime(monotonicNow());
  return map;
}

/// Counts up with whatever the stored map should show.
std::int64_t GraphThread::changes() const {
  return static_cast<std::int64_t>(builder_->backEnd().keyframes().size()) + builder_->backEnd().generation() +
         views_.added();
}

void GraphThread::store(DrawnMap drawn) {
  if (!keeper_.writes() || builder_->backEnd().keyframes().size() == 0) return;
  ends_.pose.load(snapshot_);
  const auto map = std::make_shared<const MapState>(mapState(std::move(drawn), builder_->backEnd().keyframes().size()));
  // Behind a journal that is being written these views may be in it already: twice does no harm.
  const auto seen = views_.unjournalled();
  const auto outcome = std::make_shared<Outcome>();
  stored_ = outcome;
  disk_.start([this, map, seen, outcome, changes = changes(), may_journal = !checkpoint_wanted_] {
    const Timestamp now = monotonicNow();
    if (keeper_.retryDue(now)) keeper_.retry(now);
    outcome->saved = keeper_.checkpoint(now, *map, changes, *seen);
    // A journal needs less room, and waits for no further attempt.
    if (!outcome->saved && may_journal && keeper_.hasJournal())
      outcome->saved = keeper_.journal(now, *map, *seen, changes);
  });
}

std::string GraphThread::loss() const {
  const int all = builder_->backEnd().keyframes().size(), stored = std::min(all, keeper_.stored());
  const std::string why = keeper_.problem().words();
  return std::to_string(all - stored) + " of " + std::to_string(all) + " keyframes are lost" +
         (why.empty() ? "" : "; map " + why);
}

bool GraphThread::waitUntilStored(Timestamp deadline) {
  return disk_.waitUntilIdle(deadline) && (!stored_ || stored_->saved);
}

void GraphThread::takeIn() {
  // Sights first: the keyframe that one was seen near is in the other queue by then.
  sights_.clear();
  ends_.front_end.sights.drain([this](const DepthObservation& sight) { sights_.push_back(sight); });
  ends_.front_end.keyframes.drain([this](const Keyframe& keyframe) { add(keyframe); });
  for (const DepthObservation& sight : sights_) add(sight);
}

void GraphThread::add(const DepthObservation& sight) {
  if (sight.map_id != map_id_) return;
  const auto view = builder_->add(sight);
  if (!view) return;
  if (keeper_.writes()) views_.add(*view);
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = sight.laser.stamp;
  change->views.push_back(*view);
  changes_.push_back(std::move(change));
}

void GraphThread::add(const Keyframe& keyframe) {
  if (keyframe.map_id != map_id_ || without_map_) return;  // of the map before, or nothing to find it in
  MapUpdate update = builder_->add(keyframe);
  BackEndCounters counters = builder_->backEnd().counters();
  const auto tell = [&](const char* cause, const std::string& text, LogLine::Level level) {
    if (const auto line = log_.happened(cause, {}, text, level, monotonicNow())) logLine(*line);
  };
  if (update.relocalised) tell("found", "found in the map", LogLine::kInfo);
  if (update.taken_back) {
    tell(
        "taken back",
        "the robot got lost soon after it was found: what it saw on the way is left out of the map, which is as before",
        LogLine::kWarning);
  }
  if (update.begun_anew) {
    tell("anew", "the map begins anew: what came before the robot was lost is too little to be found in",
         LogLine::kWarning);
  }
  if (!update.poses.empty()) ends_.loop_closure.add(update.work);
  if (update.loop_closed) {
    tell("loop",
         "loop closed: " + std::to_string(counters.loop_closures) + " closures join " +
             std::to_string(counters.keyframes) + " keyframes",
         LogLine::kInfo);
  }
  counters.placed += placed_before_;
  counters.begun_anew += begun_anew_before_;
  ends_.counters.store(counters);
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = keyframe.stamp;
  change->first_in_map = update.first_in_map;
  change->scans = std::move(update.scans);
  change->poses = std::move(update.poses);
  changes_.push_back(std::move(change));
  checkpoint_wanted_ |= update.begun_anew && keeper_.writes();
  if (update.correction) {
    update.correction->map_id = map_id_;
    if (all_config_.runtime.realtime) update.correction->reference.takeMemory();
    const bool sent = ends_.front_end.corrections.tryPush(update.correction.get());
    sent ? static_cast<void>(update.correction.release()) : builder_->recycle(std::move(update.correction));
  }
}

void GraphThread::sendChanges() {
  while (!changes_.empty() && ends_.map.changes.hasRoom()) {
    ends_.map.changes.tryPush(changes_.front());
    changes_.pop_front();
  }
}

void GraphThread::finish() {
  takeIn();
  sendChanges();
}

}  // namespace slam
