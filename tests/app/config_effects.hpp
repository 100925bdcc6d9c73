// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "app/observables.hpp"

namespace slam::test {

/// One key, another value of it, and where its effect shows.
struct Effect {
  const char* key;                      ///< section.key
  const char* value;                    ///< TOML
  Observable observable;                ///< nullptr: shown by the test named in `elsewhere`
  std::vector<std::string> given = {};  ///< settings of both runs
  const char* elsewhere = "";           ///< "file: test", where only a running daemon shows it
};

std::vector<Effect> effectsOfDevices();     ///< mode, store, lidar, base, imu, can, depth, lcm, runtime, output
std::vector<Effect> effectsOfEstimation();  ///< ekf, match, reference, keyframe, search, localisation
std::vector<Effect> effectsOfMap();         ///< map, loop_closure, relocalisation

}  // namespace slam::test
