// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/robot/simulation.hpp"

namespace slam::sim {

Simulation::Simulation(const Scene& scene, std::uint64_t seed, Timestamp start, const RobotErrors& errors)
    : driver_(scene), robot_(errors, seed), now_(start) {
  history_.push(now_, robot_.pose());
}

void Simulation::step() {
  const double dt = toSeconds(kStep);
  if (released_) ++driven_;
  robot_.step(released_ ? driver_.command(robot_.pose(), dt) : Twist2{}, dt);
  now_ += kStep;
  history_.push(now_, robot_.pose());
  if (released_ && driver_.reached() >= 0) visits_.push_back({now_, driver_.reached(), robot_.pose()});
}

}  // namespace slam::sim
