// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "slam/back_end_config.hpp"
#include "slam/merge/map_merge.hpp"

namespace slam {

/// A merge of two maps of a folder of maps, which both stay as they are.
struct StoredMerge {
  std::filesystem::path directory;    ///< of all maps
  std::string first, second, merged;  ///< names
  BackEndConfig back_end = {};
  OccupancyGridConfig grid = {};  ///< whose cells are as large as the first map's
  bool furniture_moved = false;   ///< between the two: less of it agrees than on two floors that look alike
  std::string pictures = {};      ///< prefix of the pictures of two places that both fit; empty: none are written

  /// Stores the merged map; what a start continues stays what it was. @return what was done, in words
  /// @param progress is called with the share [1] that is done
  /// @throws std::runtime_error with the reason why not; then nothing was stored. Where the furniture differs, it is a
  /// CommandRefused
  std::string carryOut(const std::function<void(double)>& progress = {}) const;
};

}  // namespace slam
