// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware_if/outgoing.hpp"

/// Packet serial of RoboClaw, a controller of two motors with encoders: README.md is its specification. Bytes to raw
/// values and back: std only, no heap, no I/O.
namespace slam::roboclaw {

inline constexpr int kBaud = 38400;  ///< [bit/s] as delivered
inline constexpr std::uint8_t kFirstAddress = 0x80, kLastAddress = 0x87;
inline constexpr std::uint8_t kDone = 0xFF;  ///< answer to a command that sets something
inline constexpr double kPacketGap = 0.010;  ///< [s] between two bytes of one packet: more begins it anew
inline constexpr int kTenths = 5;  ///< [0.1 s] without a packet it stops both motors by itself, as slamd sets it
inline constexpr std::size_t kCountsSize = 10;      ///< [bytes] of the answer to askCounts()
inline constexpr std::size_t kLongestVersion = 50;  ///< [bytes] the same, with its checksum

enum class Command : std::uint8_t { kTimeout = 14, kVersion = 21, kSpeeds = 37, kCounts = 78 };

Outgoing askVersion(std::uint8_t address);
Outgoing askCounts(std::uint8_t address);
/// @param speeds [counts/s] of motor 1 and 2
Outgoing encodeSpeeds(std::uint8_t address, const std::array<std::int32_t, 2>& speeds);

/// Sets its serial timeout until its power goes. @param tenths [0.1 s]; 0: it never stops by itself
Outgoing encodeTimeout(std::uint8_t address, std::uint8_t tenths);

/// @param bytes kCountsSize of them @return nullopt: its checksum is wrong
std::optional<std::array<std::uint32_t, 2>> parseCounts(std::uint8_t address, std::span<const std::uint8_t> bytes);
/// Whether these bytes end with a version, a text that ends with a line feed and a zero, whatever came before it.
bool endsWithVersion(std::uint8_t address, std::span<const std::uint8_t> bytes);

// As the controller does:

Outgoing encodeCounts(std::uint8_t address, const std::array<std::uint32_t, 2>& counts);
Outgoing encodeVersion(std::uint8_t address);
/// @return [bytes] of a packet that begins so; 0: none does
std::size_t sizeOf(std::span<const std::uint8_t> packet);
/// @return nullopt: another command, or a wrong checksum
std::optional<std::array<std::int32_t, 2>> parseSpeeds(std::span<const std::uint8_t> packet);
/// @return [0.1 s]; nullopt as for parseSpeeds()
std::optional<std::uint8_t> parseTimeout(std::span<const std::uint8_t> packet);

}  // namespace slam::roboclaw
