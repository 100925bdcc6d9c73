// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <limits>
#include <string>

#include "config/config.hpp"

namespace slam {

struct LiftDriveOptions {
  std::string begin_in;      ///< name of the map that the robot goes on in
  std::string arrive_in;     ///< name of the map of the floor that the lift takes it to; empty: it takes none
  std::string floors = "*";  ///< maps that it is searched in, see loadFloors()
  double departs = std::numeric_limits<double>::infinity();  ///< [s] since the log's begin, out of the cabin up there
};

/// A drive with a lift in it, or without one, in maps that the robot changes between as slamd does.
struct LiftDriveReport {
  int doubts = 0;         ///< times that the floor became uncertain
  int lost = 0;           ///< times that the place in the map was given up, the beginning included
  double lasted = 0.0;    ///< [s] the whole drive
  double in_doubt = 0.0;  ///< [s]
  double unknown = 0.0;   ///< [s] initialising or lost
  bool was_sure = false;  ///< localised in `begin_in` until then
  double known = std::numeric_limits<double>::infinity();  ///< [s] from the departure to sure and right
  double driven = 0.0;                                     ///< [m] until then
  double wrong_and_sure = 0.0;                             ///< [s] localised in a map that is not the floor's
  std::string ends_in;                                     ///< name of the map at the end
  bool ends_sure = false;                                  ///< localised in it
};

/// @param maps folder of the maps
/// @throws std::runtime_error when a file cannot be read, or the log holds no scan
LiftDriveReport driveWithLift(const std::filesystem::path& log, const std::filesystem::path& maps, const Config& config,
                              const LiftDriveOptions& options);

}  // namespace slam
