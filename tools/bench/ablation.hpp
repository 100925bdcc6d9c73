// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "tools/bench/front_end_rules.hpp"
#include "tools/bench/lift_drive.hpp"
#include "tools/bench/log_truth.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/eval/metrics.hpp"

namespace slam {

/// A drive on which rules are judged.
struct AblationCase {
  enum class Measure {
    kRelations,   ///< known relative poses, of the final and of the causal poses
    kCourse,      ///< a true course in a frame of its own
    kTruth,       ///< true poses in the map's frame
    kKnown,       ///< the same, of the scans alone at which the robot says that it is localised
    kOverlay,     ///< the last visit's scans on the first one's walls
    kColdStarts,  ///< in a given map
    kLift,        ///< between floors that have maps
    kNone,        ///< nothing is known of where it went
  };
  std::string name;
  Measure measure = Measure::kTruth;
  Config config;
  std::filesystem::path log;
  std::vector<LogSample> samples = {};
  std::vector<Timestamp> stamps = {};  ///< of the scans, as recorded, before the fault
  Trajectory truth = {};
  std::vector<Relation> relations = {};
  MapState map;
  LogTruth places = {};
  std::filesystem::path maps = {};  ///< folder, of a drive with a lift
  LiftDriveOptions lift = {};
};

/// Reads a list of cases, a line each: NAME | MEASURE | CONFIG | LOG | TRUTH | FAULT | KEY=VALUE ...
/// TRUTH is a file, or for cold starts a map, or for a lift FOLDER MAP MAP SECONDS: the folder of the
/// maps, where the robot begins and arrives, and when it leaves the lift; - is none. An empty line and one that begins
/// with # are left out.
/// @throws std::runtime_error with file and line
std::vector<AblationCase> readCases(const std::filesystem::path& list);

/// What came out of a case.
struct AblationFigures {
  std::vector<double> errors;  ///< [m] smaller is better; of cold starts the share that is not right [1]
  double lost = 0.0;  ///< [1] scans at which the robot does not say that it is localised; starts not found; time
                      ///< behind a lift until the robot is sure of the right floor
  double sure_and_wrong = 0.0;  ///< [1] of the others; starts found elsewhere; time sure of a wrong floor
};
AblationFigures runCase(const AblationCase& which, const Rule* without);

/// Runs all cases with each rule left out. @param rules none: all @param done called in order, first without a rule
void ablate(std::span<const AblationCase> cases, std::span<const Rule* const> rules, int jobs,
            const std::function<void(const Rule* without, const std::vector<AblationFigures>& of_cases)>& done);

}  // namespace slam
