// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/robot/simulation.hpp"

#include <algorithm>
#include <cmath>

namespace slam::sim {
namespace {
constexpr double kReach = 0.2;                 // [m] of the robot's hull before and behind the middle of its axle
constexpr double kClearance = 0.02;            // [m]
constexpr double kBottom = 0.02, kTop = 0.35;  // [m] above the floor: what the hull can run into
}  // namespace

Simulation::Simulation(const Scene& scene, std::uint64_t seed, Timestamp start, const RobotErrors& errors,
                       const DifferentialBase& nominal)
    : scene_(scene), driver_(scene), robot_(errors, seed, nominal), now_(start) {
  history_.push(now_, robot_.pose());
}

void Simulation::carryTo(std::size_t waypoint, double heading, double seconds) {
  const Pose2& place = scene_.route[waypoint].pose;
  carrying_ = {robot_.pose(), {place.x, place.y, heading}, waypoint, seconds, 0.0};
}

void Simulation::carry(double dt) {
  carrying_->done = std::min(carrying_->seconds, carrying_->done + dt);
  const double part = carrying_->done / carrying_->seconds, share = part * part * (3.0 - 2.0 * part);
  const Pose2 &from = carrying_->from, &to = carrying_->to;
  robot_.carry({from.x + share * (to.x - from.x), from.y + share * (to.y - from.y),
                wrapAngle(from.theta + share * wrapAngle(to.theta - from.theta))},
               dt);
  if (part < 1.0) return;
  driver_.continueFrom(carrying_->waypoint);
  carrying_.reset();
}

Twist2 Simulation::unobstructed() const {
  if (told_->vx == 0.0) return *told_;
  const Eigen::Vector2d end = robot_.pose() * Eigen::Vector2d(std::copysign(kReach, told_->vx), 0.0);
  return scene_.world.occupied(end, kBottom, kTop, kClearance) ? Twist2{} : *told_;
}

void Simulation::step() {
  const double dt = toSeconds(kStep);
  if (released_) ++driven_;
  if (carrying_) {
    carry(dt);
  } else {
    robot_.step(told_ ? unobstructed() : released_ ? driver_.command(robot_.pose(), dt) : Twist2{}, dt);
  }
  now_ += kStep;
  history_.push(now_, robot_.pose());
  if (released_ && driver_.reached() >= 0) visits_.push_back({now_, driver_.reached(), robot_.pose()});
}

}  // namespace slam::sim
