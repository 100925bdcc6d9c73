// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/sensor_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace slam {
namespace {

/// Folded to (-pi/2, pi/2]: the two may change their signs together.
double angleOf(double scans, double other) {
  const double angle = std::atan2(scans, other);
  return angle > std::numbers::pi / 2     ? angle - std::numbers::pi
         : angle <= -std::numbers::pi / 2 ? angle + std::numbers::pi
                                          : angle;
}

/// Direction of travel at the middle of a bend.
double directionOf(const Pose2& motion) { return std::atan2(motion.y, motion.x) - 0.5 * motion.theta; }

}  // namespace

SensorFindings withDistances(const SensorFindings& findings, const WheelScale& scale, const SensorCheckConfig& config) {
  if (scale.sigma() > config.known_scale) return findings;
  SensorFindings assessed;
  bool explained = false;  // wheels or scans are wrong in another way
  for (const SensorFinding& finding : findings.all()) {
    if (finding.fault == SensorFault::kWheelDistanceOff) continue;
    assessed.add(finding.fault, finding.value, finding.second);
    explained |= finding.fault != SensorFault::kScansRepeated && finding.fault != SensorFault::kTimeBackwards &&
                 finding.fault != SensorFault::kWheelTurnOff && finding.fault != SensorFault::kLidarMountOff;
  }
  if (!explained && std::abs(scale.value() - 1.0) > config.off_scale) {
    assessed.add(SensorFault::kWheelDistanceOff, scale.value());
  }
  return assessed;
}

SensorFindings withGyro(const SensorFindings& findings, const GyroVerdict& gyro) {
  SensorFindings assessed;
  for (const SensorFinding& finding : findings.all())
    if (finding.fault != SensorFault::kGyroReversed) assessed.add(finding.fault, finding.value, finding.second);
  const auto add = [&](SensorFault fault) { assessed.add(fault, gyro.value); };
  switch (gyro.fault) {
    case GyroFault::kNone:
      break;
    case GyroFault::kReversed:
      add(SensorFault::kGyroReversed);
      break;
    case GyroFault::kDegrees:
      add(SensorFault::kGyroDegrees);
      break;
    case GyroFault::kScale:
      add(SensorFault::kGyroTurnOff);
      break;
    case GyroFault::kOffset:
      add(gyro.reliability == GyroReliability::kRejected ? SensorFault::kGyroFarOff : SensorFault::kGyroOffset);
      break;
    case GyroFault::kClipped:
      add(SensorFault::kGyroClipped);
      break;
    case GyroFault::kUnrelated:
      add(SensorFault::kGyroContradicts);
      break;
  }
  return assessed;
}

SensorFindings withMount(const SensorFindings& findings, const MountError& mount, const SensorCheckConfig& config) {
  SensorFindings assessed = findings;
  for (const SensorFinding& finding : findings.all())
    if (finding.fault <= SensorFault::kLidarYawOff) return assessed;
  const Eigen::Vector3d sigma = mount.covariance.diagonal().cwiseSqrt();
  if (const double yaw = mount.mean.z(); std::abs(yaw) > std::max(config.off_yaw, config.sure * sigma.z()))
    assessed.add(SensorFault::kLidarYawOff, yaw);
  const Eigen::Vector2d offset = mount.mean.head<2>();
  if (offset.norm() > std::max(config.off_offset, config.sure * sigma.head<2>().maxCoeff()))
    assessed.add(SensorFault::kLidarMountOff, offset.x(), offset.y());
  return assessed;
}

void AngleCounts::add(double angle) {
  const double turns = angle / period_ + 0.5;
  const int bin = static_cast<int>(std::floor((turns - std::floor(turns)) * kBins));
  ++bins_[static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1))];
  ++count_;
}

AngleCounts::Peak AngleCounts::peak() const {
  if (count_ == 0) return {};
  const auto at = [&](int bin) { return bins_[static_cast<std::size_t>((bin + kBins) % kBins)]; };
  int best = 0, most = -1;
  for (int middle = 0; middle < kBins; ++middle) {
    int sum = 0;
    for (int k = -kReach; k <= kReach; ++k) sum += at(middle + k);
    if (sum <= most) continue;
    most = sum;
    best = middle;
  }
  double mean = 0.0;
  for (int k = -kReach; k <= kReach; ++k) mean += static_cast<double>(k * at(best + k)) / most;
  const double turns = (best + 0.5 + mean) / kBins - 0.5;
  return {period_ * (turns - std::floor(turns + 0.5)), static_cast<double>(most) / count_};
}

int AngleCounts::between(double low, double high) const {
  int sum = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const double middle = period_ * ((bin + 0.5) / kBins - 0.5);
    if (middle > low && middle < high) sum += bins_[static_cast<std::size_t>(bin)];
  }
  return sum;
}

SensorCheck::SensorCheck(const SensorCheckConfig& config)
    : config_(config),
      gyro_turn_(std::numbers::pi),
      wheel_turn_(std::numbers::pi),
      wheel_distance_(std::numbers::pi),
      wheel_direction_(2.0 * std::numbers::pi) {}

void SensorCheck::add(const MotionEvidence& evidence) {
  ++pairs_;
  const auto addTurn = [&](AngleCounts& angles, double other) {
    if (std::max(std::abs(evidence.scans.theta), std::abs(other)) < config_.least_turn) return;
    angles.add(angleOf(evidence.scans.theta, other));
  };
  if (evidence.turn_seen && evidence.gyro_turn) addTurn(gyro_turn_, *evidence.gyro_turn);
  if (!evidence.wheels) return;
  if (evidence.turn_seen && evidence.wheels_turn_known) addTurn(wheel_turn_, evidence.wheels->theta);
  if (!evidence.travel_seen || std::abs(evidence.scans.theta) > config_.straight) return;
  const double by_scans = evidence.scans.translation().norm(), by_wheels = evidence.wheels->translation().norm();
  if (std::max(by_scans, by_wheels) < config_.least_travel) return;
  wheel_distance_.add(angleOf(by_scans, by_wheels));
  if (std::min(by_scans, by_wheels) < 0.5 * config_.least_travel) return;
  wheel_direction_.add(directionOf(evidence.scans) - directionOf(*evidence.wheels));
}

void SensorCheck::addScan(bool repeated, double back) {
  ++scans_;
  repeated_ += repeated;
  backwards_ += back > 0.0;
  clock_steps_ += back > config_.clock_step;
}

bool SensorCheck::wants(bool turn) const {
  if (pairs_ < config_.wanted) return true;
  return (turn ? std::max(gyro_turn_.count(), wheel_turn_.count()) : wheel_direction_.count()) < config_.wanted;
}

SensorCheck::Relation SensorCheck::relation(const AngleCounts& angles, double same_size) const {
  const AngleCounts::Peak peak = angles.peak();
  const double size = std::abs(peak.angle);
  const bool alike = peak.share >= config_.most && peak.share * angles.count() >= config_.least_alike;
  if (alike && peak.angle > config_.both_move && size < std::numbers::pi / 2 - config_.both_move &&
      std::abs(size - std::numbers::pi / 4) > same_size) {
    return Relation::kScaled;
  }
  const double least = std::max(static_cast<double>(config_.least_alike), config_.most * angles.count());
  if (angles.between(config_.both_move, std::numbers::pi / 2 - config_.both_move) >= least) return Relation::kAgrees;
  if (angles.between(config_.both_move - std::numbers::pi / 2, -config_.both_move) >= least) return Relation::kOpposite;
  const bool usual = angles.count() >= config_.many_pairs && angles.count() > config_.usual * pairs_;  // slips are few
  return usual ? Relation::kUnrelated : Relation::kUnknown;
}

SensorFindings SensorCheck::findings() const {
  SensorFindings findings;
  checkDirections(findings);
  checkWheels(findings);
  const auto many = [&](int count, double share) { return count >= config_.least_count && count >= share * scans_; };
  if (many(repeated_, config_.repeated_share)) findings.add(SensorFault::kScansRepeated, repeated_);
  if (clock_steps_ > 0 || many(backwards_, config_.backwards_share))
    findings.add(SensorFault::kTimeBackwards, backwards_);
  return findings;
}

void SensorCheck::checkDirections(SensorFindings& findings) const {
  const Relation gyro = relation(gyro_turn_, config_.same_size), wheels = relation(wheel_turn_, config_.same_size);
  const AngleCounts::Peak travel = wheel_direction_.peak();
  const bool travel_known =
      travel.share >= config_.most && travel.share * wheel_direction_.count() >= config_.least_alike;
  const bool reversed = travel_known && std::abs(travel.angle) > std::numbers::pi - config_.yaw_tolerance;
  const auto undecided = [this](Relation relation, const AngleCounts& angles) {
    return relation == Relation::kUnknown && angles.count() > 0 && angles.count() < config_.many_pairs;
  };
  if (undecided(gyro, gyro_turn_) || undecided(wheels, wheel_turn_)) return;  // it may show which other is right
  if (gyro == Relation::kOpposite) {
    findings.add(wheels == Relation::kOpposite  ? SensorFault::kLidarUpsideDown
                 : wheels == Relation::kUnknown ? SensorFault::kLidarAgainstGyro
                                                : SensorFault::kGyroReversed);
  } else if (wheels == Relation::kOpposite) {
    findings.add(reversed                     ? SensorFault::kWheelsBackwards
                 : gyro == Relation::kUnknown ? SensorFault::kLidarAgainstWheels
                                              : SensorFault::kWheelsSwapped);
    if (reversed) return;  // which explains the direction, too
  }
  if (travel_known && std::abs(travel.angle) > config_.yaw_tolerance)
    findings.add(SensorFault::kLidarYawOff, -travel.angle);
}

void SensorCheck::checkWheels(SensorFindings& findings) const {
  // In turns most wheels slip by some share.
  const bool many = wheel_distance_.count() >= config_.wanted;
  const Relation distance = relation(wheel_distance_, many ? config_.nearly_same : config_.same_size);
  const Relation turn = relation(wheel_turn_, config_.same_size);
  if (distance == Relation::kScaled) {
    findings.add(SensorFault::kWheelDistanceOff, 1.0 / std::tan(wheel_distance_.peak().angle));
  }
  if (turn == Relation::kScaled) findings.add(SensorFault::kWheelTurnOff, 1.0 / std::tan(wheel_turn_.peak().angle));
  if (distance == Relation::kUnrelated || turn == Relation::kUnrelated) findings.add(SensorFault::kWheelsContradict);
}

}  // namespace slam
