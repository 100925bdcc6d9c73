// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/map_jobs.hpp"

#include <algorithm>
#include <utility>

#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kLoadLimit = 10s;                // a disk that takes longer for the first map is not waited for
constexpr Duration kDiskHangs = 3s;                 // in one job
const Eigen::Vector3d kMovedSigma(0.1, 0.1, 0.05);  // [m, m, rad] the robot may have driven on meanwhile

}  // namespace

MapJobs::MapJobs(const Config& config, const GraphEnds& ends, GraphWork& work, StorePolicy& policy)
    : config_(config), ends_(ends), work_(work), policy_(policy), keeper_(config) {
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

void MapJobs::beginIn(MapState map) {
  requested_.reset();
  policy_.beginMap(keeper_.writes());
  work_.beginIn(std::move(map), keeper_.localises());
}

void MapJobs::changeTo(MapState next, const std::optional<Pose2>& T_next_base) {
  if (T_next_base) next.T_map_base = *T_next_base;
  beginIn(std::move(next));
  auto front_end = work_.newFrontEnd();
  if (T_next_base) front_end->setPose(*T_next_base, kMovedSigma);
  if (ends_.front_end.front_ends.tryPush(front_end.get())) front_end.release();
}

/// Where the robot is in the map that a command changes to: in the present one in another frame it goes on where it is,
/// and in another one where it was found. A session that has begun since is somewhere else. Of maps that look alike the
/// one that a person loads is the right one.
std::optional<Pose2> MapJobs::poseAfter(const MapCommands::Command& command) const {
  if (command.T_next_map) return *command.T_next_map * work_.lastPose();
  const auto& floor = command.asked.floor;
  if (!floor) return command.asked.kind == MapCommand::kLoad ? work_.placeIn(command.asked.name) : std::nullopt;
  if (!work_.isInSession(*floor)) return std::nullopt;
  return floor->T_floor_session * work_.trackedPose();
}

bool MapJobs::hangs() const { return disk_.blockedFor(monotonicNow()) > kDiskHangs; }

void MapJobs::tick() {
  ends_.commands.drain([this](const MapCommand& command) { commands_.take(command, hangs()); });
  const bool free = diskIsFree();
  if (hangs()) commands_.refuseAll();
  ends_.map.grids.drain([this](const std::shared_ptr<DrawnMap>& drawn) {
    // Where the map has moved since, it is asked for again.
    if (requested_ && requested_->generation == work_.backEnd().generation()) return writeCheckpoint(std::move(*drawn));
    if (const auto stale = std::exchange(requested_, std::nullopt)) policy_.cancelAttempt(stale->extent);
  });
  if (free && !disk_.isBusy() && !requested_) beginDue(monotonicNow());
}

void MapJobs::beginDue(Timestamp now) {
  if (keeper_.retryDue(now)) return retry(now);
  if (auto floor = work_.takeFloor(); floor && !commands_.isWaiting())
    commands_.take({.kind = MapCommand::kLoad, .id = 0, .name = floor->name, .floor = floor}, hangs());
  if (commands_.isWaiting()) return requestGrid();
  if (!keeper_.mayWrite(now) || work_.backEnd().keyframes().size() == 0) return;
  switch (policy_.due(now, work_.changes(), work_.lastPose(), keeper_.hasJournal())) {
    case StorePolicy::Due::kCheckpoint:
      return requestGrid();
    case StorePolicy::Due::kJournal:
      return writeJournal(now);
    case StorePolicy::Due::kNothing:
      return;
  }
}

void MapJobs::start(std::function<void()> job, std::function<void()> then) {
  then_ = std::move(then);
  disk_.start(std::move(job));
}

/// Does what was to be done behind the last job.
bool MapJobs::diskIsFree() {
  if (disk_.isBusy()) return false;
  if (const auto then = std::exchange(then_, nullptr)) then();
  return true;
}

void MapJobs::requestGrid() {
  const auto& map = work_.backEnd();
  requested_ = {map.keyframes().size(), map.generation(), policy_.beginAttempt(work_.changes(), work_.lastPose())};
  work_.requestGrid();
}

void MapJobs::writeCheckpoint(DrawnMap drawn) {
  Requested shown = *std::exchange(requested_, std::nullopt);
  const auto map = std::make_shared<const MapState>(work_.state(std::move(drawn), shown.keyframes));
  shown.extent.T_map_base = map->T_map_base;
  const auto written = std::make_shared<bool>(false);
  const Timestamp now = monotonicNow();
  start(
      [this, map, seen = policy_.views().unjournalled(), written, now, command = commands_.begin()] {
        *written = keeper_.checkpoint(now, *map, *seen);
        if (command) commands_.carryOut(*command, *map, *written);
      },
      [this, written, now, extent = shown.extent] {
        policy_.endAttempt(StorePolicy::Due::kCheckpoint, extent, now, *written);
        if (const auto command = commands_.end(); command && command->next)
          changeTo(std::move(*command->next), poseAfter(*command));
      });
}

void MapJobs::writeJournal(Timestamp now) {
  const auto map = std::make_shared<const MapState>(
      work_.state({OccupancyGrid(config_.map), {}}, work_.backEnd().keyframes().size()));
  const auto written = std::make_shared<bool>(false);
  start([this, now, map, seen = policy_.views().unjournalled(),
         written] { *written = keeper_.journal(now, *map, *seen); },
        [this, now, written, extent = policy_.beginAttempt(work_.changes(), map->T_map_base)] {
          policy_.endAttempt(StorePolicy::Due::kJournal, extent, now, *written);
        });
}

void MapJobs::retry(Timestamp now) {
  const auto found = std::make_shared<std::optional<MapState>>();
  start([this, now, found] { *found = keeper_.retry(now); },
        [this, found] {
          if (*found) changeTo(std::move(**found));
        });
}

void MapJobs::store(DrawnMap drawn) {
  const int keyframes = work_.backEnd().keyframes().size();
  if (!keeper_.writes() || keyframes == 0) return;
  const auto map = std::make_shared<const MapState>(work_.state(std::move(drawn), keyframes));
  const auto written = std::make_shared<bool>(false);
  stored_ = written;
  // Behind a journal that is being written these views may be in it already: twice does no harm.
  disk_.start([this, map, seen = policy_.views().unjournalled(), written, may_journal = !policy_.requiresCheckpoint()] {
    const Timestamp now = monotonicNow();
    // The last chance, however long ago the one before was. A map that came late is not what was drawn meanwhile.
    if (keeper_.waitsForDisk() && keeper_.retry(now)) keeper_.beginNew(now);
    *written = keeper_.checkpoint(now, *map, *seen);
    // A journal needs less room, and waits for no further attempt.
    if (!*written && may_journal && keeper_.hasJournal()) *written = keeper_.journal(now, *map, *seen);
  });
}

std::string MapJobs::loss() const {
  const int all = work_.backEnd().keyframes().size(), stored = std::min(all, keeper_.stored());
  const std::string why = keeper_.problem().words();
  return std::to_string(all - stored) + " of " + std::to_string(all) + " keyframes are lost" +
         (why.empty() ? "" : "; map " + why);
}

bool MapJobs::waitUntilStored(Timestamp deadline) { return disk_.waitUntilIdle(deadline) && (!stored_ || *stored_); }

}  // namespace slam
