// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "firmware_if/frame_decoder.hpp"
#include "firmware_if/outgoing.hpp"

/// Messages of the Xbus, as an Xsens MTi has them on its serial port and USB: FA FF, identifier, length, data, sum. A
/// length of FF means that two bytes with the length follow. Big-endian.
/// [XSE] xsens/xsens_mti_ros_node, mtdef.py and mtdevice.py; "MT Low-Level Communication Protocol".
namespace slam::xsens {

/// Identifiers of messages.
inline constexpr std::uint8_t kAskId = 0x00;  ///< answered in the mode for configuration alone
inline constexpr std::uint8_t kGoToMeasurement = 0x10, kGoToConfig = 0x30, kData2 = 0x36, kWakeUp = 0x3E, kError = 0x42;
inline constexpr std::size_t kOverhead = 5;                ///< [bytes] around the data of a short message
inline constexpr std::size_t kMostData = 512;              ///< [bytes] with all outputs on it is 300
inline constexpr std::int64_t kTickNanoseconds = 100'000;  ///< [ns] of one tick of the sample time

struct Format {
  static constexpr std::size_t kLongest = kOverhead + 2 + kMostData;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> message);
};
using Decoder = FrameDecoder<Format>;

struct Message {
  std::uint8_t id = 0;
  std::span<const std::uint8_t> data{};  ///< within the bytes that were parsed
};
/// @param bytes of a message that the decoder has found
Message parse(std::span<const std::uint8_t> bytes);

/// What a message of kData2 has of what is used.
struct Motion {
  std::optional<std::uint16_t> counter{};               ///< one more with each message; it wraps
  std::optional<std::uint32_t> ticks{};                 ///< sample time since the unit's start; it wraps after 119 h
  std::optional<std::array<double, 3>> turn_rate{};     ///< [rad/s]; numbers of any kind
  std::optional<std::array<double, 3>> acceleration{};  ///< [m/s^2] specific force; numbers of any kind
};
/// @return nullopt: the blocks do not fit into the data
std::optional<Motion> parseMotion(std::span<const std::uint8_t> data);

/// A message without data.
Outgoing encode(std::uint8_t id);
/// As the unit sends it, with floats. @param out the bytes are appended
void encode(const Motion& motion, std::vector<std::uint8_t>& out);
void encode(const Message& message, std::vector<std::uint8_t>& out);

}  // namespace slam::xsens
