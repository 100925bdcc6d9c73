// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <unistd.h>
#include <vector>

#include "build_paths.hpp"
#include "support/process.hpp"

namespace slam::test {

/// A simulated robot with a camera, which this process's OpenNI2 finds; its files go with it.
class SimulatedCamera {
 public:
  SimulatedCamera() {
    std::filesystem::create_directories(directory_);
    setenv("SLAM_SIM_DEVICES", directory_.c_str(), 1);
  }
  ~SimulatedCamera() {
    simulator_.reset();
    std::filesystem::remove_all(directory_);
  }
  SimulatedCamera(const SimulatedCamera&) = delete;
  SimulatedCamera& operator=(const SimulatedCamera&) = delete;

  /// The robot stands at the origin: a wall 3.05 m ahead of the camera, a box 2.05 m ahead on its left.
  void simulate() {
    simulator_.emplace(
        std::vector<std::string>{SLAMD_BINARY_DIR "/slam-sim", "--scene", "tile-rectangle", "--devices", directory_},
        directory_ / "sim.txt");
  }
  void inject(const std::string& fault) const {
    std::ofstream(directory_ / "faults") << "depth " << fault << std::endl;
  }

 protected:
  const std::filesystem::path directory_ =
      std::filesystem::path(testing::TempDir()) / ("camera_" + std::to_string(getpid()));
  std::optional<Process> simulator_;
};

}  // namespace slam::test
