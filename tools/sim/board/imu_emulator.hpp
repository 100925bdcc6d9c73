// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

namespace slam::sim {

/// A stand-alone HandsFree IMU at byte level.
class ImuEmulator {
 public:
  enum class Framing : std::uint8_t { kA9, kB6 };
  explicit ImuEmulator(Framing framing, std::uint64_t seed = 1) : framing_(framing), random_(seed) {}

  /// One set of frames; to be called at the unit's rate. @param gyro [rad/s] counter-clockwise about x forward, y left,
  /// z up @param accel [m/s^2] specific force, (0, 0, +9.81) at rest @param out the bytes are appended
  void sample(const std::array<double, 3>& gyro, const std::array<double, 3>& accel, std::vector<std::uint8_t>& out);

  /// Makes something go wrong from then on, or right again. @return false: no such kind, or not a value for it
  bool inject(std::string_view kind, double value);

 private:
  void send(std::span<std::uint8_t> frame, std::vector<std::uint8_t>& out);

  Framing framing_;
  std::mt19937_64 random_;
  std::array<double, 3> gyro_{}, accel_{};  // [rad/s], [m/s^2]
  bool silent_ = false, garbage_ = false, stuck_ = false, no_accel_ = false;
  int wrong_checksums_ = 0, slow_ = 1, samples_ = 0;
  double factor_ = 1.0;
};

}  // namespace slam::sim
