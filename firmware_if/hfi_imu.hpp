// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware_if/frame_decoder.hpp"

/// The stand-alone serial IMU A9 of HandsFree; README.md is the specification. Bytes to raw values and back: std only,
/// no heap, no I/O. B6, B9 and D6 send WitMotion's frames.
namespace slam::hfi {

/// A9, frame of motion (length 2C).
struct A9Motion {
  std::array<float, 3> gyro{};      ///< [rad/s]
  std::array<float, 3> accel{};     ///< [g], the sign of gravity: (0, 0, -1) at rest
  std::array<float, 3> magnetic{};  ///< unit not known
};
/// A9, frame of attitude (length 14).
struct A9Attitude {
  float roll = 0.0F, pitch = 0.0F, yaw = 0.0F;  ///< [deg]
};

inline constexpr std::uint8_t kA9MotionLength = 0x2C, kA9AttitudeLength = 0x14;
inline constexpr std::size_t kA9Overhead = 5;  ///< AA 55 length ... CRC_low CRC_high
inline constexpr std::size_t kA9MaxFrame = kA9MotionLength + kA9Overhead;

/// CRC-16/MODBUS, over the length and the data.
std::uint16_t crc16(std::span<const std::uint8_t> bytes);

std::array<std::uint8_t, kA9MotionLength + kA9Overhead> encodeA9(const A9Motion& value);
std::array<std::uint8_t, kA9AttitudeLength + kA9Overhead> encodeA9(const A9Attitude& value);
/// @param frame that the decoder has found. @return std::nullopt: another one, or a value that is not finite
std::optional<A9Motion> parseA9Motion(std::span<const std::uint8_t> frame);

struct A9Format {
  static constexpr std::size_t kLongest = kA9MaxFrame;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> frame);
};
using A9Decoder = FrameDecoder<A9Format>;

}  // namespace slam::hfi
