// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "slam/map_state.hpp"
#include "slam/pipeline.hpp"
#include "tools/faults/stream_fault.hpp"

namespace slam {

/// The samples of a log in its order.
std::vector<LogSample> readSamples(const std::filesystem::path& log);

/// @return what a scan did; nothing of another sample
std::optional<ScanOutcome> addTo(Pipeline& pipeline, const LogSample& sample);

/// Where the robot of a log was in a given map.
struct LogTruth {
  struct Row {
    Timestamp stamp;
    Pose2 T_map_base;
  };
  std::vector<Row> rows;  ///< one a scan
  double seen = 0.0;      ///< [1] share of the walls of the log's own map that are at their places in the given one
  double margin = 0.0;    ///< log-likelihood over the second best place for the whole log
};

/// The log's own map, made without the given one, is laid into it as a whole: of all places the one that explains the
/// whole log best, in the scale that does, and then part by part, each bound to its neighbours, since both maps are
/// bent. No pose depends on how a robot without a guess finds itself, and along a bare corridor the log's own map
/// bridges what the given one does not tell.
/// @throws std::runtime_error when the log holds no scans, or fits nowhere
LogTruth fitLog(const std::vector<LogSample>& samples, const Config& config, const MapState& map);

}  // namespace slam
