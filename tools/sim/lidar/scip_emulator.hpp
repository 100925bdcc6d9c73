// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "tools/sim/lidar/turn_emulator.hpp"

namespace slam::sim {

/// A model of Hokuyo, by what it answers to PP.
struct ScipModel {
  const char* name;     ///< for slam-sim
  const char* product;  ///< MODL
  int steps_per_turn, first, last, front;
  int least_mm, most_mm;
  int turns_per_minute;
};
std::span<const ScipModel> scipModels();

/// A lidar of Hokuyo at byte level, on USB or Ethernet: answers commands of SCIP 2.0, sends scans of MD without end.
class ScipEmulator : public TurnEmulator {
 public:
  ScipEmulator(Measure measure, const ScipModel& model);

 private:
  std::string answerTo(std::string_view command) override;
  std::string encode(std::span<const double> ranges, Duration began, std::uint32_t number) override;

  const ScipModel& model_;
  std::string scan_;  // the command that began it
};

}  // namespace slam::sim
