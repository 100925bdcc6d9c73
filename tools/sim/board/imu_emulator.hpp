// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "tools/sim/imu/faulty_imu.hpp"

namespace slam::sim {

/// A stand-alone HandsFree IMU at byte level.
class ImuEmulator : public FaultyImu {
 public:
  enum class Framing : std::uint8_t { kA9, kB6 };
  explicit ImuEmulator(Framing framing, std::uint64_t seed = 1) : FaultyImu(seed), framing_(framing) {}

 protected:
  void encode(const Vector& gyro, const Vector& accel, Bytes& out) override;

 private:
  Framing framing_;
};

}  // namespace slam::sim
