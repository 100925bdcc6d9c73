// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/map_state.hpp"
#include "store/map_journal.hpp"

namespace slam {

/// What load() would find.
struct MapSummary {
  std::string name;
  int generation = 0;      ///< newest one that can be used; 0: none
  int newest = 0;          ///< newest one there is
  int keyframes = 0;       ///< in it
  std::int64_t utime = 0;  ///< [us] of its last pose
  bool newer = false;      ///< a newer slamd wrote it: none of it can be used
  std::string problem;     ///< what is wrong with it, in the words of load(); empty: nothing
};

struct LoadedMap {
  MapState state;
  int generation = 0;
  std::vector<std::string> remarks;  ///< what was damaged and what was used instead, one sentence each
};

/// Maps on disk. A folder holds one folder a map:
///
///     NAME/000007/MANIFEST        format version, and size and CRC-32 of each other file and of itself
///     NAME/000007/keyframes.bin   scans and poses
///     NAME/000007/graph.bin       edges
///     NAME/000007/grid.bin        occupancy by the lidar
///     NAME/000007/depth.bin       occupancy by the depth camera, and the views it was drawn from
///     NAME/000007/state.toml      last pose, gyro bias, calibration
///     NAME/000007.journal         what came after generation 7
///     NAME/lock                   held by the program that writes the map
///
/// A checkpoint is written beside the others, synced, and renamed to its number, so that it is there whole or not at
/// all; the intact generation before it stays, with its journal, as the one to fall back to. Whatever is cut off or
/// flipped, no more is lost than the journal had not yet synced.
class MapStore {
 public:
  /// @throws std::runtime_error where the folder cannot be made
  MapStore(std::filesystem::path directory, std::string name);

  const std::string& name() const { return name_; }
  /// The newest one there is; 0: none.
  int generation() const { return generation_; }

  /// Writes the whole map as a new generation and begins a new journal. @throws std::runtime_error; then the
  /// generations before are as they were
  /// @param seen by the depth camera since the last call of append(), for the journal that leads up to this generation
  void checkpoint(const MapState& map, std::span<const MapView> seen = {});
  /// Writes what has changed since, into the journal. @param seen by the depth camera since the last call
  /// @throws std::runtime_error
  void append(const MapState& map, std::span<const MapView> seen = {});
  void sync();
  /// Makes it the map that was written last.
  void touch();

  /// The newest state that can be read.
  /// @param grid of the grid to make
  /// @throws std::runtime_error with one sentence when nothing of it can be used, or a newer slamd wrote it
  static LoadedMap load(const std::filesystem::path& directory, const std::string& name,
                        const OccupancyGridConfig& grid);

  /// All maps of a folder, by name. Reads each as load() does, but draws nothing.
  static std::vector<MapSummary> list(const std::filesystem::path& directory);
  /// The map that was written last, intact or not, if there is one.
  static std::optional<std::string> newest(const std::filesystem::path& directory);
  /// Letters, digits, - _ and . not at the beginning: a name that is no path.
  static bool isName(const std::string& name);

 private:
  std::filesystem::path directory_;  // of this map
  std::string name_;
  int generation_ = 0;
  int first_written_ = 0;  // by this object; 0: none yet
  std::unique_ptr<MapJournal> journal_;
};

/// A map by its path: of a map_server .yaml, or a map's folder in a store.
/// @throws std::runtime_error with one sentence
LoadedMap openMap(const std::filesystem::path& path, const OccupancyGridConfig& grid);

}  // namespace slam
