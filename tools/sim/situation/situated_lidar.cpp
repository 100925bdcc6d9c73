// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/situated_lidar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam::sim {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr Pose2 kRear{-0.10, 0.0, std::numbers::pi};   // T_base_lidar of the second one, as it is believed
constexpr double kHalfView = 0.75 * std::numbers::pi;  // [rad] of each of two lidars, which overlap at the sides

}  // namespace

SituatedLidar::SituatedLidar(const World& world, const Situation& situation, std::uint64_t seed)
    : world_(world),
      situation_(situation),
      model_(world, situation.lidar, seed),
      company_(situation),
      panes_(Panes::drawn(world, situation.glass, situation.mirrors, seed)),
      random_(seed ^ 0xD6E8FEB86659FD93ULL),
      beam_time_(situation.field_of_view / kTurn / (situation.turn_rate * situation.beams)),
      gap_((1.0 - situation.field_of_view / kTurn) / situation.turn_rate) {}

double SituatedLidar::bearing(int index) const {
  const double first = situation_.field_of_view < kTurn ? situation_.field_of_view / 2 : 0.0;
  return wrapAngle(-(situation_.field_of_view * index / situation_.beams - first));  // ahead of a full turn: -0
}

float SituatedLidar::claimedRangeMax() const {
  return static_cast<float>(situation_.claimed_range_max.value_or(situation_.lidar.range_max));
}

double SituatedLidar::sight(const Pose2& T_world_base, const Pose2& T_base_lidar, double bearing, bool& world) {
  double truth;
  if (panes_.panes().empty()) {
    truth = model_.trueRange(T_world_base, bearing, T_base_lidar);
  } else {
    const Pose2 lidar = T_world_base * T_base_lidar;
    const double direction = lidar.theta + bearing;
    truth = panes_.castRay(world_, {lidar.x, lidar.y, LidarModel::kHeight},
                           {std::cos(direction), std::sin(direction), 0.0}, situation_.lidar.range_max);
  }
  const double company = company_.range(T_base_lidar, bearing);
  world = company >= truth;
  return world ? truth : company;
}

SituatedLidar::Look SituatedLidar::look(const Pose2& T_world_base, int index, bool covered) {
  const double ahead = bearing(index);
  // Where both of two lidars look, beams are of either in turn.
  const double off = std::abs(ahead);
  const bool rear =
      situation_.second_lidar && (off > kHalfView || (index % 2 == 1 && off > std::numbers::pi - kHalfView));
  const Pose2 mounted =
      rear ? kRear * Pose2{0.0, 0.0, *situation_.second_lidar} : LidarModel::kExtrinsics * situation_.mount_error;
  const double own = rear ? wrapAngle(ahead - std::numbers::pi) : ahead;
  Look look;
  const double stretched = own * (1.0 + situation_.bearing_scale);
  double range = model_.measure(stretched, [&](double b) { return sight(T_world_base, mounted, b, look.world); });
  if (range > 0.0) range = std::max(0.0, range * (1.0 + situation_.range_scale) + situation_.range_bias);
  if (covered) range = 0.0;
  look.world = look.world && range > 0.0;
  look.beam = {.range = static_cast<float>(range),
               .bearing = static_cast<float>(ahead),
               .intensity = range > 0.0 ? 15.0F : 0.0F};
  if (rear && range > 0.0) {  // merged in the frame of the first
    const Eigen::Vector2d p =
        LidarModel::kExtrinsics.inverse() * (kRear * Eigen::Vector2d(range * std::cos(own), range * std::sin(own)));
    look.beam.range = static_cast<float>(p.norm());
    look.beam.bearing = static_cast<float>(std::atan2(p.y(), p.x()));
  }
  if (range == 0.0) {
    const auto& codes = situation_.no_return.ranges;
    look.beam.range = codes[std::uniform_int_distribution<std::size_t>(0, codes.size() - 1)(random_)];
    if (situation_.no_return.beyond_reach) look.beam.range += static_cast<float>(situation_.lidar.range_max);
  }
  return look;
}

}  // namespace slam::sim
