// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "config/config.hpp"
#include "matching/match_result.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// Two scans whose relative pose is known, and what the wheels say about it.
struct ScanPair {
  ScanPoints reference, scan;  ///< with normals, in base
  Pose2 T_ref_scan;            ///< known
  Pose2 guess;                 ///< of the wheels
};

/// Pairs from a log and its relations file: rows shorter than `max_interval` whose stamps are both scans.
/// @throws std::runtime_error when a file cannot be read
std::vector<ScanPair> loadScanPairs(const std::filesystem::path& log, const std::filesystem::path& relations,
                                    const Config& config, double max_interval = 6.0);

enum class Matcher { kPointToPoint, kPointToLine, kPointToLineOrSearch };

/// Outcome over all pairs for one strength of noise on the guess.
struct PairReport {
  double success = 0.0;          ///< [1] share within 0.10 m and 2 deg
  double wrong_converged = 0.0;  ///< [1] share of all that is wrong but called converged
  int wrong = 0, wrong_refused = 0;
  double median_translation = 0.0, median_rotation = 0.0;  ///< [m], [deg] of the successes
  double median_iterations = 0.0, p99_iterations = 0.0;
  double median_us = 0.0, p99_us = 0.0;  ///< of one match
};

/// @param translation_noise, rotation_noise  uniform, +- [m], [rad] on x, y and theta of the guess
PairReport matchPairs(const std::vector<ScanPair>& pairs, Matcher matcher, double translation_noise,
                      double rotation_noise, std::uint64_t seed, const Config& config);

}  // namespace slam
