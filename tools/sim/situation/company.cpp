// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/company.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace slam::sim {
namespace {

constexpr double kFollowing = 0.55;                      // [m] behind the base
constexpr double kNearest = 0.9, kFarther = 0.15;        // [m] of walkers; each farther than the one before
constexpr double kReaction = 0.7, kFastest = 1.4;        // [s, m/s] of a walker
constexpr double kHitch = 0.30, kPole = 0.60;            // [m] from base to hitch, on to the cart's axle
constexpr double kCartLength = 0.60, kCartWidth = 0.45;  // [m]
constexpr double kCartBottom = 0.05, kCartTop = 0.60;    // [m]

double swingOf(double way) { return Person::kSwing * std::sin(2.0 * std::numbers::pi * way / Person::kStride); }

}  // namespace

Company::Company(const Situation& situation) : situation_(situation) {
  for (int i = 0; i < situation.walkers; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / situation.walkers;
    const double away = kNearest + kFarther * (i % 4);
    walkers_.push_back({.place = {away * std::cos(angle), away * std::sin(angle)}, .at = {0.0, 0.0}});
  }
}

void Company::addLegs(const Pose2& T_base_person, double swing) {
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector2d foot = T_base_person * Eigen::Vector2d(side * swing, side * Person::kFeetApart / 2);
    solids_.cylinders.push_back({foot.x(), foot.y(), Person::kLegRadius, 0.0, Person::kHipHeight});
  }
}

/// Walks towards the place in the robot's company, no faster than people do.
void Company::stepWalker(Walker& walker, double dt) {
  const Eigen::Vector2d left = *T_world_base_ * walker.place - walker.at;
  const Eigen::Vector2d step = left * std::min(dt / kReaction, kFastest * dt / std::max(left.norm(), 1e-9));
  walker.at += step;
  walker.way += step.norm();
  if (step.norm() > 0.05 * dt) walker.heading = std::atan2(step.y(), step.x());
  const Pose2 T_world_person{walker.at.x(), walker.at.y(), walker.heading};
  addLegs(between(*T_world_base_, T_world_person), swingOf(walker.way));
}

void Company::step(const Pose2& T_world_base, double dt) {
  const bool first = !T_world_base_;
  if (!first) path_length_ += (T_world_base.translation() - T_world_base_->translation()).norm();
  T_world_base_ = T_world_base;
  if (first) {
    for (Walker& walker : walkers_) walker.at = T_world_base * walker.place;
    axle_ = T_world_base * Eigen::Vector2d(-kHitch - kPole, 0.0);
  }
  solids_.clear();
  if (situation_.follower != Situation::Follower::kNone) {
    addLegs({-kFollowing, 0.0, 0.0},
            situation_.follower == Situation::Follower::kSwaying ? swingOf(path_length_) : 0.0);
  }
  for (Walker& walker : walkers_) stepWalker(walker, dt);
  if (situation_.cart) {  // its axle rolls along the pole alone
    const Eigen::Vector2d hitch(-kHitch, 0.0), pole = T_world_base * hitch - axle_;
    axle_ += pole.normalized() * (pole.norm() - kPole);
    const Eigen::Vector2d axle = T_world_base.inverse() * axle_, along = hitch - axle;
    solids_.boxes.push_back(
        {axle.x(), axle.y(), std::atan2(along.y(), along.x()), kCartLength, kCartWidth, kCartBottom, kCartTop});
  }
}

double Company::range(const Pose2& T_base_lidar, double bearing) const {
  const double direction = T_base_lidar.theta + bearing;
  double nearest = solids_.castRay({T_base_lidar.x, T_base_lidar.y, LidarModel::kHeight},
                                   {std::cos(direction), std::sin(direction), 0.0});
  for (const BodyArc& body : situation_.bodies) {
    if (std::abs(wrapAngle(bearing - body.middle)) <= body.half_width) nearest = std::min(nearest, body.range);
  }
  if (situation_.floor_line && std::cos(bearing) > 1e-6) {
    nearest = std::min(nearest, *situation_.floor_line / std::cos(bearing));
  }
  return nearest;
}

}  // namespace slam::sim
