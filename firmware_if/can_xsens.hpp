// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "firmware_if/can_frame.hpp"

/// IMU on CAN with the frames of an Xsens MTi; README.md is their specification. Frames to raw values and back: std
/// only, no heap, no I/O. A parse function returns std::nullopt for a frame of another id or kind, or of a wrong size.
namespace slam::can::xsens {

inline constexpr std::uint32_t kSampleTime = 0x005, kQuaternion = 0x021, kRateOfTurn = 0x032, kAcceleration = 0x034;

inline constexpr std::int64_t kTickNanoseconds = 100'000;  ///< [ns] of one tick of the sample time

/// [ticks of 1e-4 s] since the unit's start; begins at 0 again after 119 h.
Frame encodeSampleTime(std::uint32_t ticks);
std::optional<std::uint32_t> parseSampleTime(const Frame& frame);

/// Makes one count of a sample time that wraps. A count that goes back by less than half of its range is a unit that
/// was started anew, and is given back as such: smaller than before.
class TickCounter {
 public:
  /// @return [ticks] as many as counted since the unit's start, wraps included
  std::int64_t count(std::uint32_t ticks);

 private:
  std::optional<std::uint32_t> last_;
  std::int64_t count_ = 0;  // [ticks]
};

using Vector3 = std::array<float, 3>;

/// w, x, y, z; each -1..1.
using Quaternion = std::array<float, 4>;
Frame encodeQuaternion(const Quaternion& value);

/// [rad/s], steps of 2^-9, at most 64.
Frame encodeRateOfTurn(const Vector3& value);
std::optional<Vector3> parseRateOfTurn(const Frame& frame);

/// [m/s^2] specific force, steps of 2^-8, at most 128.
Frame encodeAcceleration(const Vector3& value);
std::optional<Vector3> parseAcceleration(const Frame& frame);

}  // namespace slam::can::xsens
