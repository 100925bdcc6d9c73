// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/stored_map.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <utility>

#include "slam/edits/straighten.hpp"
#include "slam/keyframe_map.hpp"
#include "store/durable_file.hpp"
#include "store/map_folders.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam {
namespace {

constexpr std::size_t kMostEdits = 1000;                 // of a file
constexpr int kAttempts = 3;                             // to read a map that slamd writes at that moment
constexpr std::chrono::milliseconds kBetweenWrites(50);  // its journal is written within less

/// @throws std::runtime_error where some of it is damaged
LoadedMap undamaged(const StoredMap& map) {
  LoadedMap loaded = MapStore::load(map.directory, map.name, map.grid);
  if (loaded.remarks.empty()) return loaded;
  throw std::runtime_error(loaded.remarks.front() + "; let slamd load and save the map before it is changed");
}

void write(const StoredMap& map, const MapState& changed) {
  MapStore store(map.directory, map.name);
  MapStore::newest(map.directory) == map.name ? store.checkpoint(changed) : store.writeCopy(changed);
}

/// Locks the map, and gives what change() makes of it to the store.
template <typename Change>
void replace(const StoredMap& map, const Change& change) {
  const std::filesystem::path folder = mapFolder(map.directory, map.name);
  const FolderLock lock(folder);
  LoadedMap loaded = undamaged(map);
  write(map, change(loaded.state));
}

}  // namespace

LoadedMap loadWhole(const std::filesystem::path& directory, const std::string& name, const OccupancyGridConfig& grid) {
  const StoredMap map{directory, name, grid};
  mapFolder(map.directory, map.name);
  for (int attempt = 1;; ++attempt) {
    try {
      return undamaged(map);
    } catch (const std::runtime_error&) {
      if (attempt == kAttempts) throw;
    }
    std::this_thread::sleep_for(kBetweenWrites);
  }
}

void storeNew(const std::filesystem::path& directory, const std::string& name, const MapState& map) {
  requireFreeName(directory, name);
  try {
    MapStore(directory, name).writeCopy(map);
    syncFolder(directory);
  } catch (const std::runtime_error&) {
    std::error_code ignored;
    std::filesystem::remove_all(directory / name, ignored);
    throw;
  }
}

void StoredMap::replaceBy(const LoadedMap& before, const MapState& after) const {
  const FolderLock lock(mapFolder(directory, name));
  const LoadedMap now = undamaged(*this);
  const bool same = now.generation == before.generation && now.state.utime == before.state.utime &&
                    now.state.keyframes.size() == before.state.keyframes.size() &&
                    now.state.edits.revision == before.state.edits.revision;
  if (!same) throw std::runtime_error("map " + name + " was changed meanwhile, and stays as it is; do it again");
  write(*this, after);
}

void StoredMap::requireUnused() const { const FolderLock lock(mapFolder(directory, name)); }

std::string StoredMap::edit(std::span<const EditCommand> commands) const {
  replace(*this, [&](MapState& map) {
    KeyframeMap edited;
    edited.load(std::move(map.keyframes), std::move(map.in_map));
    edited.edits = std::move(map.edits);
    for (const EditCommand& command : commands) {
      std::vector<int> changed;
      int id = 0;
      const Problem problem = edited.edit(command, map.T_map_base.translation(), &changed, &id);
      if (problem)
        throw std::runtime_error("edit " + std::to_string(&command - commands.data() + 1) + " of " +
                                 std::to_string(commands.size()) + ": " + problem.words() + "; none was made");
    }
    map.keyframes = std::move(edited.keyframes);
    map.in_map = std::move(edited.in_map);
    map.edits = std::move(edited.edits);
    return transformed(map, Pose2{}, grid);  // draws it anew
  });
  return std::to_string(commands.size()) + (commands.size() == 1 ? " edit" : " edits") + " of map " + name;
}

std::string StoredMap::straighten(const std::string& origin) const {
  double turn = 0.0;  // [rad]
  replace(*this, [&](const MapState& map) {
    const Pose2 T_new_map = straightFrame(map, origin);
    turn = T_new_map.theta;
    return transformed(map, T_new_map, grid);
  });
  char text[40];
  std::snprintf(text, sizeof text, "turned by %.2f deg", turn * 180.0 / std::numbers::pi);
  return "map " + name + " is " + text;
}

void StoredMap::remove() const { removeMap(directory, name); }

void StoredMap::rename(const std::string& to) const { renameMap(directory, name, to); }

std::vector<std::string> editsIn(std::string_view json, const std::string& author) {
  nlohmann::json list = nlohmann::json::parse(json, nullptr, false);
  if (list.is_object()) list = nlohmann::json::array({list});
  if (!list.is_array() || list.empty())
    throw std::runtime_error("the file is no JSON list of edits; docs/api.md shows one");
  if (list.size() > kMostEdits) throw std::runtime_error("the file holds more than 1000 edits");
  std::vector<std::string> edits;
  for (nlohmann::json& edit : list) {
    if (edit.is_object() && !edit.contains("by")) edit["by"] = author;
    edits.push_back(textOf(edit));
  }
  return edits;
}

}  // namespace slam
