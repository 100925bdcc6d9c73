// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "tools/sim/lidar/turn_emulator.hpp"

namespace slam::sim {

/// A model of SICK.
struct ColaModel {
  const char* name;      ///< for slam-sim
  const char* identity;  ///< behind "sRA DeviceIdent "
  int beams, per_turn;
  double first;        ///< [deg] as it counts them, where 90 is ahead
  std::uint32_t step;  ///< [1/10000 deg] as it prints it
  int turns_per_second;
};
std::span<const ColaModel> colaModels();

/// A TiM or LMS at byte level: answers telegrams of CoLa A, sends its scans once asked to.
class ColaEmulator : public TurnEmulator {
 public:
  ColaEmulator(Measure measure, const ColaModel& model);

 private:
  std::string answerTo(std::string_view command) override;
  std::string encode(std::span<const double> ranges, Duration began, std::uint32_t number) override;
  std::string scanOf(std::string_view kind, std::span<const double> ranges, Duration began, std::uint32_t number) const;

  const ColaModel& model_;
};

}  // namespace slam::sim
