// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/map_keeper.hpp"

#include <cerrno>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "app/log/log.hpp"
#include "problems/answer.hpp"
#include "problems/answers.hpp"
#include "store/disk_problem.hpp"
#include "store/floor_maps.hpp"

namespace slam {
namespace {

bool isPicture(const std::string& map) { return std::filesystem::path(map).extension() == ".yaml"; }

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
  std::error_code unknown;  // where the folder cannot be looked into, none is known
  const auto taken = [&] {  // also by a link to nowhere
    const auto type = std::filesystem::symlink_status(directory + "/" + name, unknown).type();
    return type != std::filesystem::file_type::not_found && type != std::filesystem::file_type::none;
  };
  for (int i = 2; taken(); ++i) name = now + "-" + std::to_string(i);
  return name;
}

}  // namespace

std::string MapKeeper::misconfiguration(const Config& config) {
  const StoreConfig& store = config.store;
  const bool localise = config.mode == RunMode::kLocalise;
  if (localise && !isPicture(store.map) && store.directory.empty()) {
    return "mode: \"localise\" needs a map; set store.map, or store.directory to a folder with maps";
  }
  if (!store.floors.empty() && (isPicture(store.map) || store.directory.empty())) {
    return "store.floors: a robot is searched in stored maps; set store.directory, and store.map to a name";
  }
  if (localise || store.map.empty()) return "";
  if (isPicture(store.map)) {
    return "store.map: a picture of a map cannot be extended; set mode to \"localise\", or store.map to a name";
  }
  if (!MapStore::isName(store.map)) return "store.map: is no name of a map; use letters, digits, - and _";
  return "";
}

MapState MapKeeper::begin(Timestamp now) {
  auto map = take(now);
  return map ? std::move(*map) : MapState();
}

/// @return std::nullopt where there is none to go on in; awaits_ says whether one is still to come
std::optional<MapState> MapKeeper::take(Timestamp now) {
  const StoreConfig& store = config_.store;
  const bool localise = localises_, picture = isPicture(store.map);
  awaits_ = false;
  try {
    std::string path = picture ? store.map : "";
    name_.clear();
    if (!picture && !store.directory.empty()) {
      name_ = !store.map.empty() ? store.map : newestMap();
      if (!name_.empty()) path = store.directory + "/" + name_;
    }
    const bool exists = !path.empty() && std::filesystem::exists(path);
    if (!exists && (localise || picture)) {
      throw std::runtime_error(path.empty() ? "there is none in the folder " + store.directory
                                            : path + ": there is no such map");
    }
    if (!exists && !writes()) return std::nullopt;
    if (!exists) {
      keep(name_.empty() ? newNameIn(store.directory) : name_, now);
      // Where its folder cannot even be made, the named map may lie on a disk that is still to come.
      awaits_ = !store_ && !store.map.empty();
      if (store_) succeed();
      return std::nullopt;
    }
    if (writes() && !picture) {
      keep(name_, now);
      if (generation_ == 0) {  // a folder that nothing was stored in
        if (store_) succeed();
        return std::nullopt;
      }
    }
    MapState map = open(path);
    stored_ = known_ = map.keyframes.size();
    if (localise || store_) succeed();
    return map;
  } catch (const std::runtime_error& error) {
    store_.reset();
    lock_.reset();
    if (localise || !store.map.empty()) {  // a map that was asked for by name is not silently replaced by an empty one
      awaits_ = true;
      fail(now, {{localise ? problem::kMapToLocaliseMissing : problem::kMapNotTaken, {}, {"", "", error.what()}}});
      return std::nullopt;
    }
    logError(std::string(error.what()) + "; a new map begins, that one is left as it is");
  }
  beginNew(now);
  return std::nullopt;
}

/// The map that was gone on in last; empty: none. What lies beside it is told.
std::string MapKeeper::newestMap() const {
  std::vector<std::string> passed_over;
  const std::string newest = MapStore::newest(config_.store.directory, &passed_over).value_or("");
  for (const std::string& why : passed_over) {
    logWarning(why + "; it is left as it is, " + (newest.empty() ? "a new map begins" : "slamd continues " + newest) +
               "; slamctl list says more");
  }
  return newest;
}

/// Makes the map the one that is written, and nobody else's; where the disk refuses, retry() tries again.
/// @throws FolderLocked, then the one before stays
void MapKeeper::keep(const std::string& name, Timestamp now) {
  std::unique_ptr<MapStore> store;
  StorageProblem problem;
  int generation = 0;
  if (name != name_) stored_ = known_ = 0;
  try {
    store = std::make_unique<MapStore>(config_.store.directory, name);
    generation = store->generation();
    if (auto lock = lockOf(name)) lock_ = std::move(lock);
  } catch (const FolderLocked&) {
    throw;
  } catch (const std::runtime_error& error) {
    store.reset();
    lock_.reset();
    problem = notWritten(error);
  }
  store_ = std::move(store);
  name_ = name;
  generation_ = generation;
  has_journal_ = false;
  if (!store_) fail(now, problem);
}

std::optional<MapState> MapKeeper::retry(Timestamp now) {
  if (awaits_) return take(now);
  const int known = generation_;
  try {
    keep(name_, now);
    // As it was left, or empty because somebody has removed it.
    const bool same = generation_ == known || generation_ == 0;
    if (!store_) generation_ = known;
    if (store_ && same) succeed();
    if (!store_ || same) return std::nullopt;
    logWarning(name_ + " was written by somebody else meanwhile; this map gets another name");
  } catch (const FolderLocked& error) {
    logWarning(std::string(error.what()) + "; this map gets another name");
  }
  beginNew(now);
  return std::nullopt;
}

/// A lock of a map's folder; nullptr where it is the map that is kept, whose lock is held already.
std::unique_ptr<FolderLock> MapKeeper::lockOf(const std::string& name) const {
  if (store_ && store_->name() == name) return nullptr;
  return std::make_unique<FolderLock>(std::filesystem::path(config_.store.directory) / name);
}

MapState MapKeeper::open(const std::string& path) {
  LoadedMap loaded = openMap(path, config_.map);
  if (!config_.store.floors.empty()) {
    loaded.state.floors = loadFloors(config_.store.directory, config_.store.floors,
                                     std::filesystem::path(path).filename(), config_.front_end.lidar, &loaded.remarks);
  }
  for (const std::string& remark : loaded.remarks) logWarning(remark);
  const std::string misfit = misfitOf(loaded.state, config_.front_end.lidar, localises_);
  if (!misfit.empty()) throw std::runtime_error(path + ": " + misfit);
  logInfo("map " + path + " of " + std::to_string(loaded.state.keyframes.size()) + " keyframes");
  return std::move(loaded.state);
}

MapState MapKeeper::load(const std::string& name, Timestamp now) {
  if (config_.store.directory.empty()) throw CommandRefused(answer::kNoStore);
  if (!MapStore::isName(name)) throw CommandRefused({answer::kNoMapName, {}, {name}});
  MapState map = open(config_.store.directory + "/" + name);
  if (writes()) keep(name, now);
  stored_ = known_ = map.keyframes.size();
  name_ = name;
  awaits_ = false;
  if (store_ || !writes()) succeed();
  return map;
}

MapState MapKeeper::changeMode(bool localise, Timestamp now) {
  if (isPicture(config_.store.map)) throw CommandRefused(answer::kPictureStays);
  if (config_.store.directory.empty()) throw CommandRefused(answer::kNoStore);
  const std::string path = config_.store.directory + "/" + name_;
  const bool exists = !name_.empty() && std::filesystem::exists(path);
  if (!exists && localise) throw CommandRefused(answer::kNoMapToLocalise);
  const bool before = localises_.exchange(localise);
  try {
    MapState map = exists ? open(path) : MapState();
    if (localise) {
      store_.reset();
      lock_.reset();
    } else {
      keep(name_.empty() ? newNameIn(config_.store.directory) : name_, now);
    }
    awaits_ = false;
    if (store_ || localise) succeed();
    return map;
  } catch (const std::runtime_error&) {
    localises_ = before;
    throw;
  }
}

void MapKeeper::beginNew(Timestamp now) {
  awaits_ = false;
  if (writes()) keep(newNameIn(config_.store.directory), now);
  if (store_) succeed();
}

bool MapKeeper::journal(Timestamp now, const MapState& map, std::span<const MapView> seen) {
  bool appended = false;
  const bool written = attempt(now, map, [&] {
    store_->append(map, seen);
    appended = true;
    store_->sync();
  });
  // What a disk has once failed to sync it may have lost, and it does not say so again: all is to be written anew.
  if (!written && appended) has_journal_ = false;
  return written;
}

bool MapKeeper::checkpoint(Timestamp now, const MapState& map, std::span<const MapView> seen) {
  if (!store_ || !attempt(now, map, [&] { store_->checkpoint(map, seen); })) return false;
  if (const std::string& leftover = store_->leftover(); leftover != leftover_) {
    leftover_ = leftover;
    if (!leftover.empty()) logWarning(leftover + "; it takes room, the map is stored all the same; remove it by hand");
  }
  has_journal_ = true;
  return true;
}

void MapKeeper::saveAs(const std::string& name, const MapState& map) const {
  if (config_.store.directory.empty()) throw CommandRefused(answer::kNoStore);
  // A generation behind the back of store_ would end the journal that store_ goes on with.
  if (store_ && store_->name() == name) throw CommandRefused({answer::kMapOpen, {}, {name}});
  MapStore copy(config_.store.directory, name);
  const auto lock = lockOf(name);
  copy.writeCopy(map);
}

StorageProblem MapKeeper::notWritten(const std::exception& error) const {
  std::string since = "yet";
  if (written_ != 0) {
    const bool today = std::time(nullptr) - written_ < 12 * 3600;
    std::tm local{};
    localtime_r(&written_, &local);
    char text[32];
    std::strftime(text, sizeof text, today ? "since %H:%M" : "since %Y-%m-%d %H:%M", &local);
    since = text;
  }
  std::string meanwhile = "the map is not stored, ";
  if (known_ > stored_)
    meanwhile +=
        std::to_string(known_ - stored_) + " of " + std::to_string(known_) + " keyframes are in memory alone, ";
  const Problem problem = dynamic_cast<const UnreadableMap*>(&error) != nullptr
                              ? Problem(problem::kMapUnreadable, {}, {"", "", error.what()})
                              : diskProblem(error, config_.store.directory);
  return {problem, "not written " + since + ": ", meanwhile + "slamd tries again"};
}

bool MapKeeper::attempt(Timestamp now, const MapState& map, const std::function<void()>& write) {
  known_ = map.keyframes.size();
  try {
    // What is written into a folder that has no name any more is lost without an error.
    if (!lock_->isThere()) throw DiskError(name_ + ": somebody has removed the map's folder", ENOENT);
    write();
    stored_ = known_;
    written_ = std::time(nullptr);
    succeed();
    return true;
  } catch (const std::exception& error) {
    fail(now, notWritten(error));
    if (lock_->isThere()) return false;
    generation_ = store_->generation();
    store_.reset();
    lock_.reset();
    stored_ = 0;
    return false;
  }
}

void MapKeeper::fail(Timestamp now, StorageProblem problem) {
  retry_.failed(now);
  problem_.set(std::move(problem));
}

void MapKeeper::succeed() {
  retry_.succeeded();
  problem_.set({});
}

}  // namespace slam
