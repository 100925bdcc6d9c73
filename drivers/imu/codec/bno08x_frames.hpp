// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware_if/frame_decoder.hpp"

/// Frames of a BNO08x in UART-RVC mode: AA AA, index, three angles, three accelerations, three bytes without use,
/// sum. [BNO08X] CEVA, "BNO08X Datasheet", 1000-3927 v1.17, section 1.2.6 and figure 1-25.
namespace slam::bno08x {

inline constexpr int kBaud = 115200;           ///< [bit/s]
inline constexpr double kRate = 100.0;         ///< [Hz]
inline constexpr std::size_t kFrameSize = 19;  ///< [bytes]
inline constexpr double kDegreesPerCount = 0.01;
inline constexpr double kGravitiesPerCount = 0.001;

struct Frame {
  std::uint8_t index = 0;                      ///< one more with each frame
  std::int16_t yaw = 0, pitch = 0, roll = 0;   ///< [0.01 deg]
  std::array<std::int16_t, 3> acceleration{};  ///< [0.001 g] specific force, (0, 0, 1000) at rest
  bool operator==(const Frame&) const = default;
};

struct Format {
  static constexpr std::size_t kLongest = kFrameSize;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> frame);
};
using Decoder = FrameDecoder<Format>;

/// @param frame that the decoder has found
Frame parse(std::span<const std::uint8_t> frame);
std::array<std::uint8_t, kFrameSize> encode(const Frame& frame);

}  // namespace slam::bno08x
