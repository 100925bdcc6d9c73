// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <vector>

#include "app/config.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// How a robot that was switched on somewhere in a map, without a guess, found itself.
struct ColdStart {
  double begin = 0.0;  ///< [s] since the log's first scan
  bool found = false;
  double after = 0.0;        ///< [s] from begin to when it was found
  double translation = 0.0;  ///< [m] error then
  double rotation = 0.0;     ///< [deg] error then
};

struct ColdStartReport {
  std::vector<ColdStart> starts;
  int right = 0, wrong = 0, not_yet = 0;  ///< right: within 0.5 m and 10 deg
  std::vector<double> search_ms;          ///< of each search over the whole map
  double truth_overlap = 0.0;             ///< [1] mean over the scans of the run that is taken for the truth
  int truth_lost = 0;                     ///< times that run lost itself
};

/// Starts at `places` moments, evenly spaced over the log, and lets each drive for at most `seconds`. The truth is a
/// run over the whole log, each pose seen from its end.
/// @throws std::runtime_error when the log cannot be read or the whole run does not find itself
ColdStartReport coldStarts(const std::filesystem::path& log, const Config& config, const MapState& map, int places,
                           double seconds);

}  // namespace slam
