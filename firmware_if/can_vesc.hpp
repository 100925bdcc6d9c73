// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "firmware_if/can_frame.hpp"

/// VESC, the motor controllers of the two wheels, by extended frames: README.md is its specification. Frames to raw
/// values and back: std only, no heap, no I/O. A parse function returns std::nullopt for a frame of another id or kind,
/// or that is too short.
namespace slam::can::vesc {

inline constexpr int kMostId = 254;              ///< 255 is all of them
inline constexpr double kTimeout = 1.0;          ///< [s] without a command, as delivered: it releases the motor
inline constexpr int kStepsPerElectricTurn = 6;  ///< of the tachometer

enum class Packet : std::uint8_t { kSetRpm = 3, kStatus = 9, kStatus4 = 16, kStatus5 = 27 };

/// 29-bit identifier.
constexpr std::uint32_t idOf(int id, Packet packet) {
  return static_cast<std::uint32_t>(packet) << 8 | static_cast<std::uint32_t>(id);
}

struct Status {
  std::int32_t erpm = 0;     ///< [1/min] electric turns
  std::int16_t current = 0;  ///< [0.1 A] of the motor
  std::int16_t duty = 0;     ///< [0.001]
  friend bool operator==(const Status&, const Status&) = default;
};
Frame encode(int id, const Status& value);
std::optional<Status> parseStatus(int id, const Frame& frame);

struct Status4 {
  std::int16_t transistors = 0, motor = 0;  ///< [0.1 deg C]
  std::int16_t input_current = 0;           ///< [0.1 A]
  std::int16_t position = 0;                ///< [deg / 50] within a turn
  friend bool operator==(const Status4&, const Status4&) = default;
};
Frame encode(int id, const Status4& value);
std::optional<Status4> parseStatus4(int id, const Frame& frame);

struct Status5 {
  std::int32_t tachometer = 0;  ///< [1/6 electric turn] since its start
  std::int16_t voltage = 0;     ///< [0.1 V]
  friend bool operator==(const Status5&, const Status5&) = default;
};
Frame encode(int id, const Status5& value);
std::optional<Status5> parseStatus5(int id, const Frame& frame);

/// @param erpm [1/min] electric turns
Frame encodeSetRpm(int id, std::int32_t erpm);
std::optional<std::int32_t> parseSetRpm(int id, const Frame& frame);

}  // namespace slam::can::vesc
