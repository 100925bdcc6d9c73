// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware_if/frame_decoder.hpp"
#include "firmware_if/outgoing.hpp"

/// OpenCR, the board of TurtleBot3, which takes the place of a Dynamixel 2.0 servo with a control table: README.md is
/// its specification. Bytes to raw values and back: std only, no heap, no I/O.
namespace slam::opencr {

inline constexpr int kBaud = 1000000;             ///< [bit/s]
inline constexpr double kCountsPerTurn = 4096.0;  ///< of a wheel's servo
inline constexpr double kHeartbeatLasts = 0.5;    ///< [s] without another heartbeat: it drives by its remote control
inline constexpr double kPerUnit = 100.0;         ///< speeds are sent in 0.01 m/s and 0.01 rad/s

enum class Instruction : std::uint8_t { kPing = 1, kRead = 2, kWrite = 3, kStatus = 0x55 };
enum Address : std::uint16_t {
  kMillis = 10,  ///< first of those that are read
  kHeartbeat = 19,
  kBumpers = 28,  ///< two bytes, not 0 where one is pressed
  kBattery = 42,
  kGyroZ = 68,
  kPositions = 136,
  kEnd = 144,           ///< behind the last of those that are read
  kLinearSpeed = 150,   ///< x, y, z ...
  kAngularSpeed = 162,  ///< ... and about these
};

/// Frames in both directions. A head inside the parameters has a byte stuffed behind it.
struct Format {
  static constexpr std::size_t kLongest = 256;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> frame);
};
using Decoder = FrameDecoder<Format>;

/// A frame without its head, its stuffing and its checksum.
struct Packet {
  std::uint8_t id = 0;
  Instruction instruction = Instruction::kStatus;
  std::uint8_t error = 0;  ///< of a status
  std::array<std::uint8_t, Format::kLongest> bytes{};
  std::size_t size = 0;  ///< [bytes] of the parameters
  std::span<const std::uint8_t> parameters() const { return {bytes.data(), size}; }
};
/// @return nullopt: too short for a status
std::optional<Packet> parse(std::span<const std::uint8_t> frame);

Outgoing ping();
Outgoing readTable();
Outgoing beat(std::uint8_t heartbeat);
/// @param speed [m/s] @param turn_rate [rad/s] counter-clockwise
Outgoing encodeSpeeds(double speed, double turn_rate);

/// What is used of the control table.
struct Table {
  std::uint32_t millis = 0;               ///< [ms] since its start
  double battery = 0.0;                   ///< [V]
  bool bumped = false;                    ///< a bumper is pressed
  float turn_rate = 0.0F;                 ///< [rad/s] counter-clockwise, of its gyro
  std::array<std::uint32_t, 2> counts{};  ///< left, right, forward up
};
/// @return nullopt: no answer of the board to readTable()
std::optional<Table> parseTable(const Packet& packet);
bool isPong(const Packet& packet);  ///< the answer to ping() of an OpenCR
bool isDone(const Packet& packet);  ///< that to what has been written

// As the board does:

Outgoing encodeTable(const Table& table);
Outgoing encodePong();
Outgoing encodeDone();
/// What writing these parameters sets. @return [m/s, rad/s]; nullopt: no speeds
std::optional<std::array<double, 2>> parseSpeeds(const Packet& packet);
std::optional<std::uint8_t> parseBeat(const Packet& packet);
bool isForBoard(const Packet& packet);

}  // namespace slam::opencr
