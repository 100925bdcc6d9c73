// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "slam/back_end_config.hpp"
#include "slam/refine/map_refinement.hpp"

namespace slam {

/// `slamctl refine`: a map of a folder of maps, computed once more on a copy.
struct StoredRefinement {
  std::filesystem::path directory;  ///< of all maps
  std::string name;
  std::string refined = {};  ///< name of the result; empty: it is a new generation of the map
  BackEndConfig back_end = {};
  OccupancyGridConfig grid = {};  ///< whose cells are as large as the map's

  /// Stores the refined map if its figures fall, at the end and at once: a map is the old one or the new one whenever
  /// the program ends. Runs at the lowest priority from then on. @return what was measured and done, in words
  /// @param announce is called with memory and time that it will take, in words, before it begins
  /// @param progress is called with the share [1] that is done
  /// @throws std::runtime_error with the reason why not; then nothing was stored
  std::string carryOut(const std::function<void(const std::string&)>& announce,
                       const std::function<void(double)>& progress = {}) const;
};

}  // namespace slam
