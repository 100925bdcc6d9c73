// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "tools/sim/depth/depth_sampler.hpp"
#include "tools/sim/output.hpp"
#include "tools/sim/robot/simulation.hpp"
#include "tools/sim/world/truth_recorder.hpp"

namespace slam::sim {

/// Simulates a drive faster than real time and writes its sensor log.
/// @param depth takes the depth camera's images, in stamp order with the log; empty: none is rendered
/// @throws std::runtime_error when a file cannot be written
void writeLog(const SimOptions& options, const std::filesystem::path& log, DepthConsumer depth = {});

/// Truth files that both modes write at the end.
void writeTruth(const SimOptions& options, const std::vector<StampedPose>& poses,
                const std::vector<WaypointVisit>& visits, const TruthRecorder& seen);

/// Scene with the options' speed.
Scene sceneFor(const SimOptions& options);

}  // namespace slam::sim
