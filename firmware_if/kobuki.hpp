// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware_if/frame_decoder.hpp"
#include "firmware_if/outgoing.hpp"

/// The serial protocol of Kobuki, the base of TurtleBot 2: README.md is its specification. Bytes to raw values and
/// back: std only, no heap, no I/O.
namespace slam::kobuki {

inline constexpr int kBaud = 115200;               ///< [bit/s]
inline constexpr double kCountsPerTurn = 2578.33;  ///< of a wheel
inline constexpr double kWheelRadius = 0.035;      ///< [m]
inline constexpr double kHalfTrack = 0.115;        ///< [m]
inline constexpr double kFastest = 0.7;            ///< [m/s] of a wheel, by its maker
inline constexpr double kFeedbackRate = 50.0;      ///< [Hz]
inline constexpr double kWatchdog = 0.6;           ///< [s] without a base command: it stops the motors

/// What one frame of feedback says, as far as it is used.
struct Feedback {
  std::uint16_t stamp = 0;  ///< [ms] modulo 65536
  bool bumped = false;
  bool dropped = false;  ///< a wheel hangs in the air
  bool cliff = false;
  std::array<std::uint16_t, 2> counts{};    ///< left, right, forward up, modulo 65536
  double battery = 0.0;                     ///< [V]
  std::optional<std::int16_t> turn_rate{};  ///< [0.01 deg/s] counter-clockwise, of its gyro
};

/// Frames in both directions: AA 55, length, sub-payloads, XOR of length and these.
struct Format {
  static constexpr std::size_t kLongest = 3 + 255 + 1;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> frame);
};
using Decoder = FrameDecoder<Format>;

/// @return nullopt: a sub-payload is longer than what is left, or there is no core sensor data (an answer, dock
/// signals)
std::optional<Feedback> parseFeedback(std::span<const std::uint8_t> frame);
/// As the base sends it.
Outgoing encodeFeedback(const Feedback& feedback);

/// What a base command asks for: the speed of the outer wheel [mm/s] and a radius [mm]: 0 straight, 1 turn in place.
struct BaseCommand {
  std::int16_t speed = 0, radius = 0;
  bool operator==(const BaseCommand&) const = default;
};
/// @param speed [m/s] @param turn_rate [rad/s]
BaseCommand commandOf(double speed, double turn_rate);
/// Inverse of commandOf(), as the firmware drives: [m/s, rad/s].
std::array<double, 2> twistOf(const BaseCommand& command);
Outgoing encode(const BaseCommand& command);
/// @return nullopt: the frame has no base command
std::optional<BaseCommand> parseCommand(std::span<const std::uint8_t> frame);

}  // namespace slam::kobuki
