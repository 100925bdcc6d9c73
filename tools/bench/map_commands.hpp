// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "tools/bench/lift_drive.hpp"
#include "tools/bench/which_floor.hpp"

namespace slam {

/// `slam-benchmark cut`, `keyframes`, `floors` and `lift`: drives and maps for tools/benchmark maps.
class MapCommands {
 public:
  /// Adds the subcommands.
  explicit MapCommands(CLI::App& app);
  bool parsed() const { return cut_->parsed() || keyframes_->parsed() || floors_->parsed() || lift_->parsed(); }
  /// @throws std::runtime_error where a file cannot be read or written
  void carryOut() const;

 private:
  CLI::App* addLift(CLI::App& app);
  void cut() const;
  void writeKeyframes() const;
  void findFloors() const;
  void takeLift() const;

  const CLI::App *cut_, *keyframes_, *floors_, *lift_;
  std::string in_, out_;
  double from_ = 0.0, to_ = 1.0;  // [1] of the log
  double later_ = 0.0;            // [s]
  struct FloorSettings {
    std::string config;
    std::vector<std::string> overrides;
    WhichFloorOptions which;
    LiftDriveOptions lift;
    bool verbose = false;
  } of_floors_;
};

}  // namespace slam
