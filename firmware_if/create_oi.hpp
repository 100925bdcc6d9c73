// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware_if/frame_decoder.hpp"
#include "firmware_if/outgoing.hpp"

/// The Open Interface of iRobot Create 2 and Roomba 600 and later: README.md is its specification. Bytes to raw values
/// and back: std only, no heap, no I/O.
namespace slam::create_oi {

inline constexpr int kBaud = 115200;                ///< [bit/s]
inline constexpr double kCountsPerTurn = 508.8;     ///< of a wheel
inline constexpr double kWheelRadius = 0.036;       ///< [m]
inline constexpr double kHalfTrack = 0.1175;        ///< [m]
inline constexpr double kFastest = 0.5;             ///< [m/s] of a wheel
inline constexpr double kStreamRate = 1.0 / 0.015;  ///< [Hz] of the sensor stream

enum class Mode : std::uint8_t { kOff = 0, kPassive = 1, kSafe = 2, kFull = 3 };

/// What kStreamed brings every 15 ms.
struct Sensors {
  bool dropped = false;  ///< a wheel hangs in the air
  bool bumped = false;
  std::uint16_t voltage = 0;  ///< [mV] of the battery
  bool plugged_in = false;    ///< to the charger's plug or dock
  Mode mode = Mode::kOff;
  std::array<std::int16_t, 2> requested{};  ///< [mm/s] left, right: the speeds that it was sent last
  std::array<std::uint16_t, 2> counts{};    ///< left, right, forward up, modulo 65536
};

/// Frames of the sensor stream: 13h, count of bytes, packets, checksum.
struct StreamFormat {
  static constexpr std::size_t kLongest = 64;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> frame);
};
using StreamDecoder = FrameDecoder<StreamFormat>;

/// @return nullopt: the frame has other packets than those of Sensors
std::optional<Sensors> parseStream(std::span<const std::uint8_t> frame);
/// As the robot sends it.
Outgoing encodeStream(const Sensors& sensors);

Outgoing start();         ///< begins the interface, in passive mode: motors off
Outgoing stop();          ///< ends it: nothing is obeyed until start(), and no stream comes
Outgoing enterSafe();     ///< motors obey until a wheel drops, a cliff comes, or the charger
Outgoing askForStream();  ///< of what Sensors has
Outgoing pauseStream();
/// @param left, right [mm/s], limited to kFastest
Outgoing driveDirect(int left, int right);

}  // namespace slam::create_oi
