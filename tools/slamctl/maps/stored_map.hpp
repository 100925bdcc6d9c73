// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/occupancy_grid.hpp"
#include "slam/edits/map_edits.hpp"
#include "store/map_store.hpp"

namespace slam {

/// A map in a folder of maps that no slamd goes on in. A change is a new generation of it, so that the one before
/// stays; what slamd continues at its next start stays what it was.
struct StoredMap {
  std::filesystem::path directory;  ///< of all maps
  std::string name;
  OccupancyGridConfig grid = {};  ///< of the one to draw

  /// Carries out all of them, or none. @return what was done, in words
  /// @throws FolderLocked where slamd writes the map, std::runtime_error with the first one's reason against it
  std::string edit(std::span<const EditCommand> commands) const;
  /// Turns it so that most walls lie along its axes. @param origin name of a place; empty: the origin stays
  /// @return what was done, in words @throws as edit()
  std::string straighten(const std::string& origin) const;
  /// @throws FolderLocked where slamd writes the map, std::runtime_error where it is none, or the new name is taken
  void remove() const;
  void rename(const std::string& to) const;
  /// @throws FolderLocked where slamd writes the map, std::runtime_error where it is none
  void requireUnused() const;
  /// @param before as it was loaded, when the work on it began @throws as edit(), also where it was changed since
  void replaceBy(const LoadedMap& before, const MapState& after) const;
};

/// A map as merge and refine read it, also while slamd writes it.
/// @throws std::runtime_error where there is none, or some of it is damaged
LoadedMap loadWhole(const std::filesystem::path& directory, const std::string& name, const OccupancyGridConfig& grid);
/// Stores a map under a name that is free; what a start continues stays what it was.
/// @throws std::runtime_error with the reason why not; then nothing was stored
void storeNew(const std::filesystem::path& directory, const std::string& name, const MapState& map);

/// Edits as a JSON list, or one as an object (docs/api.md). @return each as the argument of the command map_edit
/// @param author of those that name none @throws std::runtime_error with one sentence where it is none
std::vector<std::string> editsIn(std::string_view json, const std::string& author);

}  // namespace slam
