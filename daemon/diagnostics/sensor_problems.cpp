// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/sensor_problems.hpp"

#include <array>

namespace slam {
namespace {

/// In the order of SensorFault.
constexpr std::array<const ProblemKind*, kSensorFaults> kFaults = {
    &problem::kLidarUpsideDown, &problem::kLidarAgainstGyro, &problem::kLidarAgainstWheels, &problem::kGyroReversed,
    &problem::kWheelsSwapped,   &problem::kWheelsBackwards,  &problem::kLidarYawOff,        &problem::kWheelDistanceOff,
    &problem::kWheelTurnOff,    &problem::kWheelsContradict, &problem::kScansRepeated,      &problem::kTimeBackwards,
    &problem::kLidarMountOff,   &problem::kGyroDegrees,      &problem::kGyroTurnOff,        &problem::kGyroOffset,
    &problem::kGyroFarOff,      &problem::kGyroClipped,      &problem::kGyroContradicts,    &problem::kMovesWithRobot,
    &problem::kNoReturnCodes,   &problem::kRangesScatter,    &problem::kBeamTimesMissing,   &problem::kStampsAlone,
    &problem::kWheelsDead,      &problem::kLidarDelay};

bool isShare(SensorFault fault) {
  return fault == SensorFault::kWheelDistanceOff || fault == SensorFault::kWheelTurnOff ||
         fault == SensorFault::kGyroDegrees || fault == SensorFault::kGyroTurnOff;
}

}  // namespace

Problem problemOf(const SensorFinding& finding) {
  const double value = isShare(finding.fault) ? 100.0 * finding.value : finding.value;
  return {*kFaults[static_cast<std::size_t>(finding.fault)], {value, finding.second}};
}

Problem problemOf(EchoWatch::Finding finding) {
  switch (finding) {
    case EchoWatch::Finding::kNoEcho:
      return problem::kNoEcho;
    case EchoWatch::Finding::kNear:
      return problem::kEchoesNear;
    case EchoWatch::Finding::kFar:
      return problem::kEchoesFar;
    case EchoWatch::Finding::kNone:
      break;
  }
  return {};
}

}  // namespace slam
