// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "tools/bench/cold_starts.hpp"

namespace slam {

struct WhichFloorOptions {
  std::string truth;         ///< name of the map that the log was driven in
  std::string begin_in;      ///< name of the map that the robot goes on in, which may be another one
  std::string floors = "*";  ///< maps that it is searched in, see loadFloors()
  int places = 20;           ///< starts, evenly spaced over the log
  double seconds = 20.0;     ///< [s] that each drives at most
};

/// A start of a robot that may be in any of several maps.
struct FloorStart {
  double begin = 0.0;  ///< [s] since the log's first scan
  std::string found;   ///< name of the map; empty: none within the time
  double after = 0.0;  ///< [s] from begin to when it was found
  PlaceError error;    ///< of the place in the true map; of none in another
  std::string doubt;   ///< maps of which it may be in any, at the end
};

struct WhichFloorReport {
  std::vector<FloorStart> starts;
  int right = 0, wrong = 0, undecided = 0;  ///< right: the true map, within 0.5 m and 10 deg
};

/// Starts all over a log, each time in `begin_in`, and lets each drive until one of the maps is decided for.
/// @param maps folder of the maps @throws std::runtime_error when a file cannot be read or the log does not fit its map
WhichFloorReport whichFloor(const std::filesystem::path& log, const std::filesystem::path& maps, const Config& config,
                            const WhichFloorOptions& options, const std::function<void(int done)>& progress = {});

}  // namespace slam
