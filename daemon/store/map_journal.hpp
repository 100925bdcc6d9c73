// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "slam/map_state.hpp"
#include "store/durable_file.hpp"

namespace slam {

/// A map holds what could not be read again. It is not written: what is stored stays as it is.
struct UnreadableMap : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What has changed in a map since its last checkpoint, appended as it happens. The first record says which state of
/// the map the journal continues; each further one is all that one append() wrote, so that no keyframe comes without
/// its edges. Each carries its length and a CRC: after a power cut the intact ones at the beginning count, the torn
/// rest is cut off.
class MapJournal {
 public:
  /// Begins behind `known`, the map as the checkpoint holds it. @throws std::runtime_error
  MapJournal(const std::filesystem::path& file, const MapState& known);

  /// Appends how `map` differs from what was written before, and what the depth camera has seen since.
  /// @throws UnreadableMap, or DiskError; then the journal is as it was
  void append(const MapState& map, std::span<const MapView> seen = {});
  void sync() { file_.sync(); }

  /// Applies the intact records of a journal to the map of its checkpoint.
  struct Replayed {
    int records = 0;
    bool torn = false;               ///< something follows the intact records, or the disk does not give it
    std::string unread;              ///< why the disk does not; empty: it does
    bool moved = false;              ///< keyframes that the grid may show moved
    std::vector<MapView> seen = {};  ///< views that came to those of the map
  };
  /// Throws nothing: of a file that cannot be read there are no records.
  static Replayed replay(const std::filesystem::path& file, MapState& map);

 private:
  void remember(const MapState& map);

  AppendFile file_;
  std::vector<Pose2> poses_;            // as written
  std::vector<char> in_map_, revoked_;  // as written
  std::string state_;
  int edits_ = 0;  // revision of those that were written
};

}  // namespace slam
