// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <slam/config_t.hpp>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "mapping/mapper.hpp"
#include "tools/replay/stats.hpp"

namespace slam {

struct ReplayOptions {
  std::vector<std::filesystem::path> logs = {};        ///< to read, in order
  std::filesystem::path trajectory = {}, causal = {};  ///< TUM files to write; empty: not
  std::filesystem::path odometry = {}, wheels = {};    ///< the same without the lidar, and of the wheels alone
  std::filesystem::path estimates = {};                ///< CSV file to write: what was known at each scan
  std::filesystem::path load_map = {};                 ///< map to begin in; empty: an unknown place
  std::filesystem::path save_map = {};                 ///< map to write: DIR/NAME of a store; empty: not
  bool refine = false;                                 ///< at the end, the map is computed once more (refineMap)
  std::filesystem::path map = {};                      ///< prefix of map files to write; empty: not
  std::filesystem::path viewer_frames = {};            ///< folder for pictures of the run; empty: none
  double viewer_period = 5.0;                          ///< [s] of log time between them
};

/// The configuration that a field log begins with; std::nullopt: it is none. @throws as replay()
std::optional<config_t> configOf(const std::vector<std::filesystem::path>& logs);

/// Runs the pipeline over a log in one thread, as fast as it goes. Same log, config and binary give the same bytes.
/// @throws std::runtime_error when the log cannot be read, holds no scan, or an output cannot be written
ReplayStats replay(const Config& config, const ReplayOptions& options,
                   const std::function<void(double log_seconds, bool lost)>& progress = {});

}  // namespace slam
