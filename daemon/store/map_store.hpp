// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
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
///     NAME/000007/MANIFEST        format version, and order among maps, size and CRC-32 of each other file and of
///     itself NAME/000007/keyframes.bin   scans and poses NAME/000007/graph.bin       edges NAME/000007/grid.bin
///     occupancy by the lidar NAME/000007/depth.bin       occupancy by the depth camera, and the views it was drawn
///     from NAME/000007/edits.bin       what was drawn into the map, if anything NAME/000007/state.toml      last pose,
///     gyro bias, calibration NAME/000007.journal         what came after generation 7 NAME/lock                   held
///     by the program that writes the map
///
/// A checkpoint is written beside the others, synced, read back, and renamed to its number, so that it is there whole
/// or not at all; the intact generation before it stays, with its journal, as the one to fall back to. Whatever is cut
/// off or flipped, no more is lost than the journal had not yet synced; and whatever else lies in the folder, be it a
/// pipe or a loop of links, is passed over.
class MapStore {
 public:
  /// @throws std::runtime_error where the folder cannot be made or looked into
  MapStore(std::filesystem::path directory, std::string name);

  const std::string& name() const { return name_; }
  /// The newest one, also a damaged one where all are; 0: none.
  int generation() const { return generation_; }

  /// Writes the whole map as a new generation, begins a new journal and makes it the map that a start continues.
  /// @throws UnreadableMap, or std::runtime_error of the disk; then the generations before are as they were
  /// @param seen by the depth camera since the last call of append(), for the journal that leads up to this generation
  void checkpoint(const MapState& map, std::span<const MapView> seen = {});
  /// As checkpoint(), but a start continues the others.
  void writeCopy(const MapState& map) { write(map, {}, 0); }
  /// Which older generation the last checkpoint could not remove and why; empty: none.
  const std::string& leftover() const { return leftover_; }
  /// Writes what has changed since, into the journal. @param seen by the depth camera since the last call
  /// @throws UnreadableMap, or std::runtime_error of the disk
  void append(const MapState& map, std::span<const MapView> seen = {});
  void sync();

  /// The newest state that can be read.
  /// @param grid of the grid to make
  /// @throws std::runtime_error with one sentence when nothing of it can be used, or a newer slamd wrote it
  static LoadedMap load(const std::filesystem::path& directory, const std::string& name,
                        const OccupancyGridConfig& grid);

  /// Of all folders that can hold a map, by name. @throws DiskError where the folder cannot be looked into
  static std::vector<std::string> names(const std::filesystem::path& directory);
  /// All maps of a folder, by name. Reads each as load() does, but draws nothing.
  static std::vector<MapSummary> list(const std::filesystem::path& directory);
  /// The map that was gone on in last, by the order of the manifests and not by a clock, if there is one; among those
  /// without an order, the one whose files are the newest. It may be damaged.
  /// @param passed_over out: what may have been a map and cannot be put in order, one sentence each
  /// @throws DiskError where the folder cannot be looked into
  static std::optional<std::string> newest(const std::filesystem::path& directory,
                                           std::vector<std::string>* passed_over = nullptr);
  /// Letters, digits, - _ and . not at the beginning: a name that is no path.
  static bool isName(const std::string& name);

 private:
  void write(const MapState& map, std::span<const MapView> seen, std::int64_t order);
  std::int64_t orderOfLast() const;
  int numberOfNext() const;
  void removeOld();

  std::filesystem::path directory_;  // of this map
  std::string name_;
  int generation_ = 0;
  int first_written_ = 0;  // by this object; 0: none yet
  std::string leftover_;
  std::unique_ptr<MapJournal> journal_;
};

/// A map by its path: of a map_server .yaml, or a map's folder in a store.
/// @throws std::runtime_error with one sentence
LoadedMap openMap(const std::filesystem::path& path, const OccupancyGridConfig& grid);

}  // namespace slam
