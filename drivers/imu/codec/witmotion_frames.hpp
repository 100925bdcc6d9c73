// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

#include "firmware_if/frame_decoder.hpp"

/// Frames of WitMotion IMUs: 55, type, four words, sum. HandsFree's B6, B9 and D6 send the same, with the
/// acceleration's sign turned. [WIT] WitMotion, "Standard Communication Protocol", and
/// WITMOTION/WitStandardProtocol_JY901.
namespace slam::witmotion {

inline constexpr std::size_t kFrameSize = 11;  ///< [bytes]
inline constexpr double kGravitiesPerCount = 16.0 / 32768.0;
inline constexpr double kRadiansPerSecondPerCount = 2000.0 / 32768.0 * std::numbers::pi / 180.0;

/// Of more types than these; the others are no matter here.
enum class Type : std::uint8_t {
  kTime = 0x50,
  kAcceleration = 0x51,
  kTurnRate = 0x52,
  kAngle = 0x53,
  kMagnetic = 0x54
};

struct Frame {
  Type type = Type::kAcceleration;
  std::array<std::int16_t, 4> raw{};  ///< three axes, and temperature, voltage or version
  Eigen::Vector3d scaled(double unit) const { return unit * Eigen::Vector3d(raw[0], raw[1], raw[2]); }
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

}  // namespace slam::witmotion
