// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <vector>

#include "config/config.hpp"
#include "core/pose2.hpp"
#include "slam/map_state.hpp"
#include "tools/bench/log_truth.hpp"

namespace slam {

struct PlaceError {
  double translation = 0.0;  ///< [m]
  double rotation = 0.0;     ///< [deg]
  bool right() const { return translation < 0.5 && rotation < 10.0; }
};

PlaceError errorOf(const Pose2& found, const Pose2& truth);

/// What a search over the whole map found.
struct ColdSearch {
  double after = 0.0;   ///< [s] from the start
  double margin = 0.0;  ///< of its best place's log-likelihood over any other's, see PlaceSearch::Result
  PlaceError error;
};

/// How a robot that was switched on somewhere in a map, without a guess, found itself.
struct ColdStart {
  double begin = 0.0;  ///< [s] since the log's first scan
  bool found = false;
  double after = 0.0;                ///< [s] from begin to when it was found
  PlaceError error;                  ///< then
  Pose2 T_map_base;                  ///< then
  std::vector<ColdSearch> searches;  ///< that found any place
};

struct ColdStartReport {
  std::vector<ColdStart> starts;
  int right = 0, wrong = 0, not_yet = 0;  ///< right: within 0.5 m and 10 deg
  std::vector<double> search_ms;          ///< of each search over the whole map
  double truth_seen = 0.0;                ///< [1] see LogTruth
  double truth_margin = 0.0;
};

/// Starts at `places` moments, evenly spaced over the log, and lets each drive for at most `seconds`. The truth is
/// fitLog(), which the robot under test does not take part in.
/// @param believe_none true: no place that has a rival is believed, so that all searches are seen
/// @param progress told after each start how many are done
/// @throws std::runtime_error when the log cannot be read or does not fit the map
ColdStartReport coldStarts(const std::filesystem::path& log, const Config& config, const MapState& map, int places,
                           double seconds, bool believe_none, const std::function<void(int done)>& progress = {});

struct ColdStartOptions {
  int places = 50;
  double seconds = 10.0;
  bool believe_none = false;
};
/// The same of samples whose truth is known.
ColdStartReport coldStarts(const std::vector<LogSample>& samples, const LogTruth& truth, const Config& config,
                           const MapState& map, const ColdStartOptions& options,
                           const std::function<void(int done)>& progress = {});

/// Writes a row a start, with all digits of its doubles: begin_s, after_s, x_m, y_m, theta_rad, and of each search
/// after_s and margin. What was not found stays empty.
/// @throws std::runtime_error
void writeStarts(const ColdStartReport& report, const std::filesystem::path& csv);

}  // namespace slam
