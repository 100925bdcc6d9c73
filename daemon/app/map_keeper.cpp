// SPDX-License-Identifier: BSD-3-Clause
#include "app/map_keeper.hpp"

#include <cmath>
#include <ctime>
#include <filesystem>
#include <stdexcept>

#include "app/log.hpp"

namespace slam {
namespace {

constexpr double kPoseMoved = 0.1;  // [m, rad] a pose that differs less is not written again

std::string nameOfNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "map-%Y%m%d-%H%M%S", &utc);
  return text;
}

/// A name that no map has yet: without a clock of its own a robot starts at the same time again and again.
std::string newNameIn(const std::string& directory) {
  const std::string now = nameOfNow();
  std::string name = now;
  for (int i = 2; std::filesystem::exists(directory + "/" + name); ++i) name = now + "-" + std::to_string(i);
  return name;
}

}  // namespace

MapState MapKeeper::begin() {
  const StoreConfig& store = config_.store;
  const bool localise = config_.mode == "localise";
  const bool picture = std::filesystem::path(store.map).extension() == ".yaml";
  std::string path = picture ? store.map : "";
  if (!picture && !store.directory.empty()) {
    name_ = !store.map.empty() ? store.map : MapStore::newest(store.directory).value_or("");
    if (!name_.empty()) path = store.directory + "/" + name_;
  }
  if (path.empty() && localise) {
    throw std::runtime_error("mode \"localise\" needs a map; set store.map, or store.directory to a folder with maps");
  }
  const bool exists = !path.empty() && std::filesystem::exists(path);
  if (!exists && !path.empty() && (localise || picture)) throw std::runtime_error(path + ": there is no such map");
  MapState map;
  if (exists) {
    try {
      if (!localise && !picture) keep(name_);
      map = open(path);
    } catch (const std::runtime_error& error) {
      // A map that was asked for by name is not silently replaced by an empty one.
      if (localise || !store.map.empty()) throw;
      logError(std::string(error.what()) + "; a new map begins, that one is left as it is");
      name_.clear();
      store_.reset();
      lock_.reset();
    }
  }
  if (localise || store.directory.empty()) return map;
  if (name_.empty()) name_ = newNameIn(store.directory);
  if (!store_) keep(name_);
  return map;
}

/// Makes the map the one that is written, and nobody else's.
void MapKeeper::keep(const std::string& name) {
  auto store = std::make_unique<MapStore>(config_.store.directory, name);
  if (auto lock = lockOf(name)) lock_ = std::move(lock);
  store_ = std::move(store);
}

/// A lock of a map's folder; nullptr where it is the map that is kept, whose lock is held already.
std::unique_ptr<FolderLock> MapKeeper::lockOf(const std::string& name) const {
  if (store_ && store_->name() == name) return nullptr;
  return std::make_unique<FolderLock>(std::filesystem::path(config_.store.directory) / name);
}

MapState MapKeeper::open(const std::string& path) {
  LoadedMap loaded = openMap(path, config_.map);
  for (const std::string& remark : loaded.remarks) logWarning(remark);
  const std::string mismatch = lidarMismatch(loaded.state, config_.localizer.lidar);
  if (!mismatch.empty()) throw std::runtime_error(path + ": " + mismatch);
  if (loaded.state.picture_only && config_.mode != "localise") {
    throw std::runtime_error(path + ": a picture of a map cannot be extended; set mode to \"localise\"");
  }
  logInfo("map " + path + " of " + std::to_string(loaded.state.keyframes.size()) + " keyframes");
  return std::move(loaded.state);
}

MapState MapKeeper::load(const std::string& name) {
  if (config_.store.directory.empty()) throw std::runtime_error("store.directory is not set in the configuration");
  if (!MapStore::isName(name)) throw std::runtime_error("\"" + name + "\" is no name of a map");
  MapState map = open(config_.store.directory + "/" + name);
  if (store_) keep(name);
  name_ = name;
  journalled_changes_ = checkpointed_changes_ = -1;
  return map;
}

void MapKeeper::beginNew() {
  if (!store_) return;
  name_ = newNameIn(config_.store.directory);
  keep(name_);
  journalled_changes_ = checkpointed_changes_ = -1;
}

bool MapKeeper::journalDue(Timestamp now, const Pose2& T_map_base, std::int64_t changes) const {
  if (!store_ || checkpointed_changes_ < 0 || toSeconds(now - journalled_) < config_.store.journal_period) return false;
  const Pose2 moved = between(journalled_pose_, T_map_base);
  return changes != journalled_changes_ || std::hypot(moved.x, moved.y) > kPoseMoved ||
         std::abs(moved.theta) > kPoseMoved;
}

bool MapKeeper::journal(Timestamp now, const MapState& map, std::span<const MapView> seen, std::int64_t changes) {
  journalled_ = now;
  const bool written = attempt("journal", [&] {
    store_->append(map, seen);
    store_->sync();
  });
  if (!written) return false;
  journalled_changes_ = changes;
  journalled_pose_ = map.T_map_base;
  return true;
}

bool MapKeeper::checkpointDue(Timestamp now, std::int64_t changes) const {
  if (!store_ || changes == checkpointed_changes_) return false;
  return checkpointed_changes_ < 0 || toSeconds(now - checkpointed_) >= config_.store.checkpoint_period;
}

bool MapKeeper::checkpoint(Timestamp now, const MapState& map, std::int64_t changes, std::span<const MapView> seen) {
  checkpointed_ = now;
  if (!store_) return false;
  if (!attempt("map", [&] { store_->checkpoint(map, seen); })) return false;
  checkpointed_changes_ = journalled_changes_ = changes;
  journalled_pose_ = map.T_map_base;
  return true;
}

void MapKeeper::saveAs(const std::string& name, const MapState& map) const {
  if (config_.store.directory.empty()) throw std::runtime_error("store.directory is not set in the configuration");
  MapStore copy(config_.store.directory, name);
  const auto lock = lockOf(name);
  copy.checkpoint(map);
  if (store_) store_->touch();  // it is this one that goes on
}

bool MapKeeper::attempt(const std::string& what, const std::function<void()>& write) {
  try {
    write();
    if (failing_) logInfo("the map is written again");
    failing_ = false;
    return true;
  } catch (const std::exception& error) {
    if (!failing_) logError(what + " not written: " + error.what());
    failing_ = true;
    return false;
  }
}

}  // namespace slam
