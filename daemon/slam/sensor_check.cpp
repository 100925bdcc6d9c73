// SPDX-License-Identifier: BSD-3-Clause
#include "slam/sensor_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace slam {
namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180.0;
constexpr double kLeastTurn = 0.06, kLeastTravel = 0.06;  // [rad], [m] smaller motions are noise
constexpr double kStraight = 0.20;                        // [rad] a bend hides the direction of travel
constexpr int kLeastAlike = 5;                          // pairs that agree with each other before anything is said ...
constexpr int kWanted = 25;                             // pairs of turns and of travel to gather soon
constexpr int kManyPairs = 40;                          // before "no relation at all" is said
constexpr double kUsual = 0.25;                         // [1] share of all pairs that show a motion which is no slip
constexpr double kMost = 0.60;                          // [1] share of the angles near the peak
constexpr double kSameSize = 12.0 * kDegree;            // about 45 degrees: 0.65 to 1.54 of each other
constexpr double kNearlySame = 4.5 * kDegree;           // of distances, where many pairs tell them: 0.85 to 1.17
constexpr double kKnownScale = 0.02, kOffScale = 0.05;  // [1] standard deviation, and error, of the whole way's scale
constexpr double kBothMove = 10.0 * kDegree;            // from 0 and 90 degrees: there only one of them moves
constexpr double kYawTolerance = 30.0 * kDegree;
constexpr double kClockStep = 1.0;        // [s] back by more is a clock that was set
constexpr int kLeastCount = 5;            // of repeated or misdated scans ...
constexpr double kRepeatedShare = 0.01;   // [1] ... and their share of all
constexpr double kBackwardsShare = 0.10;  // [1] many recordings hold a few, by tenths of a second; they do no harm

/// Folded to (-pi/2, pi/2]: the two may change their signs together.
double angleOf(double scans, double other) {
  const double angle = std::atan2(scans, other);
  return angle > kPi / 2 ? angle - kPi : angle <= -kPi / 2 ? angle + kPi : angle;
}

/// Direction of travel at the middle of a bend.
double directionOf(const Pose2& motion) { return std::atan2(motion.y, motion.x) - 0.5 * motion.theta; }

}  // namespace

SensorFindings withDistances(const SensorFindings& findings, const WheelScale& scale) {
  if (scale.sigma() > kKnownScale) return findings;
  SensorFindings judged;
  bool explained = false;  // wheels or scans are wrong in another way
  for (const SensorFinding& finding : findings.all()) {
    if (finding.fault == SensorFault::kWheelDistanceOff) continue;
    judged.add(finding.fault, finding.value);
    explained |= finding.fault != SensorFault::kScansRepeated && finding.fault != SensorFault::kTimeBackwards &&
                 finding.fault != SensorFault::kWheelTurnOff;
  }
  if (!explained && std::abs(scale.value() - 1.0) > kOffScale) {
    judged.add(SensorFault::kWheelDistanceOff, scale.value());
  }
  return judged;
}

std::string describe(const SensorFinding& finding) {
  const char* text = "";
  double value = finding.value;
  switch (finding.fault) {
    case SensorFault::kLidarUpsideDown:
      text = "the lidar turns opposite to gyro and wheels: is it mounted upside down? change lidar.upside_down";
      break;
    case SensorFault::kLidarAgainstGyro:
      text =
          "lidar and gyro turn in opposite directions: is the lidar upside down (change lidar.upside_down), or "
          "does the gyro's z axis point down?";
      break;
    case SensorFault::kLidarAgainstWheels:
      text =
          "lidar and wheels turn in opposite directions: is the lidar upside down (change lidar.upside_down), or "
          "are left and right wheel swapped?";
      break;
    case SensorFault::kGyroReversed:
      text = "the gyro turns opposite to lidar and wheels: does its z axis point down?";
      break;
    case SensorFault::kWheelsSwapped:
      text = "the wheels turn opposite to the lidar but drive the same way: are left and right swapped?";
      break;
    case SensorFault::kWheelsBackwards:
      text = "the wheels drive and turn opposite to the lidar: do both count backwards?";
      break;
    case SensorFault::kLidarYawOff:
      text =
          "the lidar travels in another direction than the wheels: is it turned on its mount? add %.2f rad to "
          "lidar.yaw, or look whether the wheels drive backwards";
      break;
    case SensorFault::kWheelDistanceOff:
      text = "the wheels report %.0f %% of the distance that the scans show: check base.wheel_radius (slam-calibrate)";
      value *= 100.0;
      break;
    case SensorFault::kWheelTurnOff:
      text = "the wheels report %.0f %% of the turns that the scans show: check base.half_track (slam-calibrate)";
      value *= 100.0;
      break;
    case SensorFault::kWheelsContradict:
      text = "wheels and scans do not move together: do the wheels slip or stall, or belong to another clock?";
      break;
    case SensorFault::kScansRepeated:
      text = "%.0f scans repeat the one before them: is a driver or a recorder sending twice, or the lidar stuck?";
      break;
    case SensorFault::kTimeBackwards:
      text = "%.0f scans are stamped before the one before them: was a clock set, or are records out of order?";
      break;
  }
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), text, value);
  return line.data();
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

SensorCheck::SensorCheck() : gyro_turn_(kPi), wheel_turn_(kPi), wheel_distance_(kPi), wheel_direction_(2.0 * kPi) {}

void SensorCheck::add(const MotionEvidence& evidence) {
  ++pairs_;
  const auto addTurn = [&](AngleCounts& angles, double other) {
    if (std::max(std::abs(evidence.scans.theta), std::abs(other)) < kLeastTurn) return;
    angles.add(angleOf(evidence.scans.theta, other));
  };
  if (evidence.turn_seen && evidence.gyro_turn) addTurn(gyro_turn_, *evidence.gyro_turn);
  if (!evidence.wheels) return;
  if (evidence.turn_seen && evidence.wheels_turn_known) addTurn(wheel_turn_, evidence.wheels->theta);
  if (!evidence.travel_seen || std::abs(evidence.scans.theta) > kStraight) return;
  const double seen = evidence.scans.translation().norm(), told = evidence.wheels->translation().norm();
  if (std::max(seen, told) < kLeastTravel) return;
  wheel_distance_.add(angleOf(seen, told));
  if (std::min(seen, told) < 0.5 * kLeastTravel) return;
  wheel_direction_.add(directionOf(evidence.scans) - directionOf(*evidence.wheels));
}

void SensorCheck::addScan(bool repeated, double back) {
  ++scans_;
  repeated_ += repeated;
  backwards_ += back > 0.0;
  clock_steps_ += back > kClockStep;
}

bool SensorCheck::wants(bool turn) const {
  if (pairs_ < kWanted) return true;
  return (turn ? std::max(gyro_turn_.count(), wheel_turn_.count()) : wheel_direction_.count()) < kWanted;
}

SensorCheck::Relation SensorCheck::relation(const AngleCounts& angles, double same_size) const {
  const AngleCounts::Peak peak = angles.peak();
  const double size = std::abs(peak.angle);
  const bool alike = peak.share >= kMost && peak.share * angles.count() >= kLeastAlike;
  if (alike && peak.angle > kBothMove && size < kPi / 2 - kBothMove && std::abs(size - kPi / 4) > same_size) {
    return Relation::kScaled;
  }
  const double least = std::max(static_cast<double>(kLeastAlike), kMost * angles.count());
  if (angles.between(kBothMove, kPi / 2 - kBothMove) >= least) return Relation::kAgrees;
  if (angles.between(kBothMove - kPi / 2, -kBothMove) >= least) return Relation::kOpposite;
  const bool usual = angles.count() >= kManyPairs && angles.count() > kUsual * pairs_;  // slips are few
  return usual ? Relation::kUnrelated : Relation::kUnknown;
}

SensorFindings SensorCheck::findings() const {
  SensorFindings findings;
  judgeDirections(findings);
  judgeWheels(findings);
  const auto many = [&](int count, double share) { return count >= kLeastCount && count >= share * scans_; };
  if (many(repeated_, kRepeatedShare)) findings.add(SensorFault::kScansRepeated, repeated_);
  if (clock_steps_ > 0 || many(backwards_, kBackwardsShare)) findings.add(SensorFault::kTimeBackwards, backwards_);
  return findings;
}

void SensorCheck::judgeDirections(SensorFindings& findings) const {
  const Relation gyro = relation(gyro_turn_, kSameSize), wheels = relation(wheel_turn_, kSameSize);
  const AngleCounts::Peak travel = wheel_direction_.peak();
  const bool travel_known = travel.share >= kMost && travel.share * wheel_direction_.count() >= kLeastAlike;
  const bool reversed = travel_known && std::abs(travel.angle) > kPi - kYawTolerance;
  const auto undecided = [](Relation relation, const AngleCounts& angles) {
    return relation == Relation::kUnknown && angles.count() > 0 && angles.count() < kManyPairs;
  };
  if (undecided(gyro, gyro_turn_) || undecided(wheels, wheel_turn_)) return;  // it may say who of the others is right
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
  if (travel_known && std::abs(travel.angle) > kYawTolerance) findings.add(SensorFault::kLidarYawOff, -travel.angle);
}

void SensorCheck::judgeWheels(SensorFindings& findings) const {
  // In turns most wheels slip by some share.
  const bool many = wheel_distance_.count() >= kWanted;
  const Relation distance = relation(wheel_distance_, many ? kNearlySame : kSameSize);
  const Relation turn = relation(wheel_turn_, kSameSize);
  if (distance == Relation::kScaled) {
    findings.add(SensorFault::kWheelDistanceOff, 1.0 / std::tan(wheel_distance_.peak().angle));
  }
  if (turn == Relation::kScaled) findings.add(SensorFault::kWheelTurnOff, 1.0 / std::tan(wheel_turn_.peak().angle));
  if (distance == Relation::kUnrelated || turn == Relation::kUnrelated) findings.add(SensorFault::kWheelsContradict);
}

}  // namespace slam
