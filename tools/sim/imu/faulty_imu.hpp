// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <random>

#include "tools/sim/imu/emulated_imu.hpp"

namespace slam::sim {

/// What goes wrong with an IMU.
struct ImuFaults {
  bool silent = false, garbage = false, stuck = false, no_accel = false, no_rate = false, absurd = false;
  int checksum = 0, lose = 0, insert = 0, flip = 0, slow = 1;
  double factor = 1.0;

  bool inject(std::string_view kind, double value);
};

/// What is the same for any IMU, on top of which each make encodes its frames.
class FaultyImu : public EmulatedImu {
 public:
  void sample(const Vector& gyro, const Vector& accel, Bytes& out) final;
  void receive(std::span<const std::uint8_t>, Bytes&) override {}
  bool inject(std::string_view kind, double value) override { return faults_.inject(kind, value); }

 protected:
  explicit FaultyImu(std::uint64_t seed = 1) : random_(seed) {}
  /// A period has passed, whether or not it sends. @param gyro [rad/s] that it measured; zero while it is stuck
  virtual void renew(const Vector&) {}
  /// Sends what it has measured, frame by frame.
  virtual void encode(const Vector& gyro, const Vector& accel, Bytes& out) = 0;
  void send(std::span<const std::uint8_t> frame, Bytes& out);

  bool sendsAcceleration() const { return !faults_.no_accel; }
  bool sendsTurnRate() const { return !faults_.no_rate; }

 private:
  std::mt19937_64 random_;
  Vector gyro_{}, accel_{};  // [rad/s], [m/s^2]
  ImuFaults faults_;
  int samples_ = 0;
};

}  // namespace slam::sim
