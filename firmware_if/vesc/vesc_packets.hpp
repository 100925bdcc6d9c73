// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware_if/frame_decoder.hpp"
#include "firmware_if/outgoing.hpp"

/// VESC, the controller of a wheel's motor, by the packets of its UART or USB, which it also forwards to another one
/// over CAN: firmware_if/README.md is their specification. Bytes to raw values and back: std only, no heap, no I/O.
namespace slam::vesc {

inline constexpr int kBaud = 115200;          ///< [bit/s] as delivered; USB carries any
inline constexpr double kTimeout = 1.0;       ///< [s] without a command, as delivered: it releases the motor
inline constexpr double kErpmPerStep = 10.0;  ///< [1/min] of one step per second
inline constexpr int kMostId = 254;           ///< on CAN

enum class Command : std::uint8_t { kVersion = 0, kSetRpm = 8, kSelectedValues = 50, kForward = 34 };

/// 02, size of the payload, payload, CRC-16 of it, 03. Longer payloads than kMost, which have a head of their own, are
/// none that slamd asks for.
struct Format {
  static constexpr std::size_t kHead = 2, kTail = 3, kMost = 128;
  static constexpr std::size_t kLongest = kHead + kMost + kTail;
  static std::optional<std::size_t> sizeOf(std::span<const std::uint8_t> bytes);
  static bool isGood(std::span<const std::uint8_t> frame);
};
using Decoder = FrameDecoder<Format>;

/// Which of two questions an answer belongs to: it has other fields besides those of Values.
enum class Turn : std::uint8_t { kEven, kOdd };

/// What is asked of one VESC.
struct Values {
  Turn turn = Turn::kEven;      ///< that was asked
  std::int16_t voltage = 0;     ///< [0.1 V]
  std::int32_t tachometer = 0;  ///< [1/6 electric turn] since its start
  std::uint8_t fault = 0;       ///< its code; 0: none
  std::uint8_t id = 0;          ///< on CAN
};

Outgoing askVersion();
Outgoing askValues(Turn turn);
/// @param erpm [1/min] electric turns
Outgoing setRpm(std::int32_t erpm);
/// The same packet for the VESC of that id on the CAN bus of the one that gets it. Answers come back as that one's own.
Outgoing forward(std::uint8_t id, const Outgoing& packet);

/// @param frame of a Decoder @return nullopt: no answer to askValues()
std::optional<Values> parseValues(std::span<const std::uint8_t> frame);
/// Whether it is the answer to askVersion().
bool isVersion(std::span<const std::uint8_t> frame);

// As the controller does:

Outgoing encodeVersion();
Outgoing encodeValues(const Values& values);
std::span<const std::uint8_t> payloadOf(std::span<const std::uint8_t> frame);
/// What a command asks for. @param payload of a frame, or what is behind the id of one that is forwarded
std::optional<Turn> parseAskValues(std::span<const std::uint8_t> payload);
std::optional<std::int32_t> parseSetRpm(std::span<const std::uint8_t> payload);
bool isAskVersion(std::span<const std::uint8_t> payload);
/// @return the id and what is to be forwarded to it; the id is 0 and nothing is to be forwarded where it is another one
struct Forwarded {
  std::uint8_t id = 0;
  std::span<const std::uint8_t> payload{};
};
Forwarded parseForward(std::span<const std::uint8_t> payload);

}  // namespace slam::vesc
