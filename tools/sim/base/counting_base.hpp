// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <memory>
#include <random>

#include "drivers/base/base_protocol.hpp"
#include "tools/sim/base/emulated_base.hpp"

namespace slam::sim {

/// What can go wrong with a base, whatever its make.
struct BaseFaults {
  bool silent = false, deaf = false, stuck = false, lifted = false, bumped = false;
  int lose = 0, insert = 0, flip = 0, checksum = 0;  ///< still to be done
  bool reset = false;                                ///< to be done once
  double factor = 1.0;                               ///< [1] of what the wheels turn

  /// @return false for an unknown kind or a value out of its range
  bool inject(std::string_view kind, double value);
  /// Does the damage that is due to a frame.
  void damage(EmulatedBase::Bytes& frame);

 private:
  std::mt19937 random_{1};
};

/// A base of the drivers' table: it counts what its wheels turn and drives them at two speeds.
class CountingBase : public EmulatedBase {
 public:
  /// @param first counts from which its counters begin
  CountingBase(const SimulatedGeometry& geometry, std::array<std::int64_t, 2> first)
      : geometry_(geometry), first_(first) {}

  void renew(RobotModel& robot, Timestamp now) override;
  void exchange(std::span<const std::uint8_t> in, Timestamp now, Bytes& out) override;
  bool inject(std::string_view kind, double value) override { return faults_.inject(kind, value); }
  bool inUse() const override { return in_use_; }
  Twist2 drive() const override;

 protected:
  virtual void take(std::uint8_t byte, Bytes& out) = 0;  ///< from the host
  virtual void send(Bytes&) {}                           ///< what is due without having been asked for
  virtual SideSpeeds sides() const = 0;                  ///< [m/s] that its motors are told
  virtual void restart() {}                              ///< its power was away

  void deliver(const Outgoing& frame, Bytes& out);
  std::array<std::int64_t, 2> counts() const;
  void setCountsBack();
  void use() { in_use_ = true; }
  bool lifted() const { return faults_.lifted; }
  bool bumped() const { return faults_.bumped; }
  double turnRate() const { return turn_rate_; }  ///< [rad/s] of its gyro
  Timestamp now() const { return now_; }
  const SimulatedGeometry& geometry() const { return geometry_; }

 private:
  SimulatedGeometry geometry_;
  std::array<std::int64_t, 2> first_;
  BaseFaults faults_;
  Timestamp now_{}, next_gyro_{};
  std::array<double, 2> angles_{}, turned_{};  // [rad] of the robot's wheels; as counted
  double turn_rate_ = 0.0;
  bool in_use_ = false, known_ = false;  // the latter: angles_
};

std::unique_ptr<EmulatedBase> makeArduino();
std::unique_ptr<EmulatedBase> makeCreate();
std::unique_ptr<EmulatedBase> makeFrameBase();
std::unique_ptr<EmulatedBase> makeKobuki();
std::unique_ptr<EmulatedBase> makeOpencr();
std::unique_ptr<EmulatedBase> makeRoboclaw();
std::unique_ptr<EmulatedBase> makeVesc();

}  // namespace slam::sim
