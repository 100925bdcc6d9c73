// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/estimates.hpp"
#include "core/timestamp.hpp"
#include "tools/sim/robot/robot_model.hpp"

namespace slam::sim {

/// A base at byte level, of whatever make. Pure: time and the robot come from outside.
class EmulatedBase {
 public:
  using Bytes = std::vector<std::uint8_t>;
  virtual ~EmulatedBase() = default;

  /// What the robot's wheels and gyro are at `now`; called every few milliseconds.
  virtual void renew(RobotModel& robot, Timestamp now) = 0;
  /// Bytes from the host, or none. @param out what the base sends by now is appended
  virtual void exchange(std::span<const std::uint8_t> in, Timestamp now, Bytes& out) = 0;
  /// Lets something go wrong from then on, or right again. @return false: no such kind, or not a value for it
  virtual bool inject(std::string_view kind, double value) = 0;
  /// Its plug has been pulled, or put back. A base with a battery of its own goes on.
  virtual void loseItsPlug() {}
  /// Whether somebody has asked it for something, as far as it can tell.
  virtual bool inUse() const = 0;
  /// How its motors drive the robot; nothing while a wheel hangs in the air.
  virtual Twist2 drive() const = 0;
};

/// @param driver word of base.driver @throws std::invalid_argument for one that nobody simulates
std::unique_ptr<EmulatedBase> makeBase(std::string_view driver);
/// Words of base.driver that are simulated.
std::vector<std::string> baseNames();
/// Wheels and track of such a robot, and what its encoders count in a turn.
struct SimulatedGeometry {
  DifferentialBase base;
  double counts_per_turn;
};
SimulatedGeometry geometryOf(std::string_view driver);

}  // namespace slam::sim
