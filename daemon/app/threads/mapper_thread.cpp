// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/mapper_thread.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <unistd.h>
#include <utility>

#include "app/log/log.hpp"
#include "bus/messages.hpp"
#include "mapping/map_files.hpp"

namespace slam {
namespace {

constexpr double kRate = 10.0;      // [Hz]
constexpr int kScansPerTick = 100;  // drawn anew after a loop closure: about 20 ms

/// Makes the folder that a file is to lie in. @throws std::runtime_error when nothing can be written there
void makeFolder(const std::filesystem::path& file) {
  const auto folder = std::filesystem::absolute(file).parent_path();
  std::filesystem::create_directories(folder);
  if (::access(folder.c_str(), W_OK) != 0) {
    throw std::runtime_error(folder.string() + ": cannot be written to: " + std::strerror(errno));
  }
}

void addOnce(std::vector<TileIndex>& tiles, TileIndex tile) {
  if (std::find(tiles.begin(), tiles.end(), tile) == tiles.end()) tiles.push_back(tile);
}

bool isSeenByDepth(const OccupancyGrid::Tiles::Tile& tile) {
  return std::any_of(tile.cells.begin(), tile.cells.end(), [](const auto& cell) { return cell.depth != 0; });
}

}  // namespace

MapperThread::MapperThread(const Config& config, const MapperEnds& ends, const WallClock& clock)
    : config_(config),
      ends_(ends),
      clock_(clock),
      mapper_(config.map),
      worker_({.name = "mapper", .rate = kRate}, [this] { tick(); }) {}

void MapperThread::tick() {
  const Timestamp begin = monotonicNow();
  const auto drawn = ends_.map.changes.drain([this](const auto& change) { draw(*change); });
  const bool redrawing = mapper_.work(kScansPerTick);
  if (drawn > 0 || redrawing) ends_.update.add(monotonicNow() - begin);
  for (const TileIndex& tile : mapper_.takeChangedTiles()) addOnce(unsent_, tile);
  if (ends_.requests.refresh.exchange(false)) {
    // A large map takes longer than from one refresh to the next: it is sent to its end.
    if (to_refresh_.empty())
      mapper_.grid().tiles().forEachTile([this](TileIndex t, const auto&) { to_refresh_.push_back(t); });
    meta_due_ = true;
  }
  sendTiles();
  if (ends_.requests.save.exchange(false)) save();
  if (!folder_known_) checkFolder(begin);
}

void MapperThread::draw(const MapChange& change) {
  if (change.map_id != map_id_) {  // the estimator began anew
    mapper_.reset();
    unsent_.clear();
    to_refresh_.clear();
    unsent_layers_.clear();
    map_id_ = change.map_id;
  }
  if (change.begin_in) {
    const MapState& map = *change.begin_in;
    if (map.keyframes.size() > 0)
      mapper_.load(scansOf(map), viewsOf(map), map.grid.clone(), map.grid_keyframes, drawingOf(map));
    ends_.requests.refresh = true;
  }
  mapper_.forgetBefore(change.first_in_map);
  for (const MapScan& scan : change.scans) mapper_.add(scan);
  for (const MapView& view : change.views) mapper_.add(view);
  if (!change.poses.empty()) mapper_.move(change.poses);
  if (change.edits) mapper_.apply(*change.edits, change.anew);
  if (change.send_grid) {
    mapper_.work(std::numeric_limits<int>::max());
    ends_.map.grids.tryPush(std::make_shared<DrawnMap>(drawn()));
  }
  utime_ = clock_.utime(change.stamp);
  meta_due_ = true;
  ends_.keyframes = mapper_.keyframes();
}

void MapperThread::sendTiles() {
  if (meta_due_ && ends_.tiles.meta.hasRoom()) {
    ends_.tiles.meta.tryPush(toMetaMessage(mapper_.grid(), utime_, map_id_, mapper_.keyframes()));
    meta_due_ = false;
  }
  // A few at a time: a burst of a whole map would overrun subscribers' receive buffers.
  constexpr std::size_t kTilesPerTick = 40;
  std::size_t sent = 0;
  for (auto* tiles : {&unsent_, &to_refresh_}) {  // what has changed goes first
    std::size_t gone = 0;
    for (; gone < tiles->size() && sent < kTilesPerTick && ends_.tiles.map.hasRoom(); ++gone, ++sent) {
      ends_.tiles.map.tryPush(toTileMessage(mapper_.grid(), (*tiles)[gone], utime_, map_id_));
      addOnce(unsent_layers_, (*tiles)[gone]);
    }
    tiles->erase(tiles->begin(), tiles->begin() + static_cast<std::ptrdiff_t>(gone));
  }
  sendLayers();
  if (sent > 0) ends_.bus_wakeup.notify();
}

void MapperThread::sendLayers() {
  constexpr int kTilesPerTick = 5;
  const OccupancyGrid& grid = mapper_.grid();
  auto next = unsent_layers_.begin();
  for (int sent = 0; next != unsent_layers_.end() && sent < kTilesPerTick; ++next) {
    if (!ends_.tiles.lidar.hasRoom() || !ends_.tiles.depth.hasRoom()) break;
    const auto* tile = grid.tiles().find(*next);
    if (tile == nullptr || !isSeenByDepth(*tile)) continue;
    ends_.tiles.lidar.tryPush(toTileMessage(grid, *next, utime_, map_id_, MapLayer::kLidar));
    ends_.tiles.depth.tryPush(toTileMessage(grid, *next, utime_, map_id_, MapLayer::kDepth));
    ++sent;
  }
  unsent_layers_.erase(unsent_layers_.begin(), next);
}

void MapperThread::finish() {
  ends_.map.changes.drain([this](const auto& change) { draw(*change); });
  save();
}

bool MapperThread::waitUntilSaved(Timestamp deadline) {
  return disk_.waitUntilIdle(deadline) && ends_.requests.saved != SaveOutcome::kFailed;
}

void MapperThread::save() {
  if (config_.output.map.empty()) return;
  mapper_.work(std::numeric_limits<int>::max());
  std::shared_ptr<const MapImage> image;
  try {
    image = std::make_shared<const MapImage>(renderMap(mapper_.grid()));
  } catch (const std::exception& error) {
    problem_.set({problem::kMapFilesNotSaved, {}, {"", "", error.what()}});
    logError(std::string("map not saved: ") + error.what());
    ends_.requests.saved = SaveOutcome::kFailed;
    return;
  }
  disk_.start([this, image, path = mapper_.path(), keyframes = mapper_.keyframes()] {
    try {
      makeFolder(config_.output.map);
      writeMapFiles(config_.output.map, *image, path);
      logInfo("map of " + std::to_string(keyframes) + " keyframes saved to " + config_.output.map + ".yaml");
      problem_.set({});
      ends_.requests.saved = SaveOutcome::kSaved;
    } catch (const std::exception& error) {
      problem_.set({problem::kMapFilesNotSaved, {}, {"", "", error.what()}});
      logError(std::string("map not saved: ") + error.what());
      folder_known_ = false;
      ends_.requests.saved = SaveOutcome::kFailed;
    }
  });
}

/// The map files are due at the end: who sees before that their folder is of no use can still do something about it.
void MapperThread::checkFolder(Timestamp now) {
  if (config_.output.map.empty() || !retry_.due(now) || disk_.isBusy()) return;
  retry_.failed(now);
  disk_.start([this] {
    try {
      makeFolder(config_.output.map);
      problem_.set({});
      folder_known_ = true;
    } catch (const std::exception& error) {
      problem_.set({problem::kMapFilesNotSaved, {}, {"", "", error.what()}});
    }
  });
}

}  // namespace slam
