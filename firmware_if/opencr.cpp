// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/opencr.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "firmware_if/little_endian.hpp"
#include "firmware_if/slamd_base/base_frame.hpp"

namespace slam::opencr {
namespace {

using Bytes = std::span<const std::uint8_t>;
using little_endian::wordAt;

constexpr std::uint8_t kBoard = 200;  // its id
constexpr std::uint16_t kModel = 0x5000, kPolynomial = 0x8005;
constexpr std::array<std::uint8_t, 4> kHead{0xFF, 0xFF, 0xFD, 0x00};
constexpr std::size_t kIdAt = 4, kLengthAt = 5, kInstructionAt = 7, kParametersAt = 8, kCrc = 2;
constexpr double kVolts = 0.01;

std::uint16_t crcOf(Bytes bytes) { return slamd_base::crc16(bytes.data(), bytes.size(), 0, kPolynomial); }

/// Whether the last three bytes are those that begin a head.
bool endsLikeHead(Bytes bytes) { return bytes.size() >= 3 && std::equal(bytes.end() - 3, bytes.end(), kHead.begin()); }

Outgoing makeFrame(Instruction instruction, Bytes parameters) {
  Outgoing body{static_cast<std::uint8_t>(instruction)};
  for (const std::uint8_t byte : parameters) {
    body.addByte(byte);
    if (endsLikeHead(body.bytes())) body.addByte(kHead[2]);
  }
  Outgoing out;
  out.add(kHead);
  out.addByte(kBoard);
  out.addLittle<2>(static_cast<std::uint32_t>(body.size() + kCrc));
  out.add(body.bytes());
  out.addLittle<2>(crcOf(out.bytes()));
  return out;
}

std::uint32_t longAt(Bytes bytes, std::size_t offset) {
  return wordAt(bytes, offset) | static_cast<std::uint32_t>(wordAt(bytes, offset + 2)) << 16;
}

bool isStatus(const Packet& packet, std::size_t size) {
  return packet.id == kBoard && packet.instruction == Instruction::kStatus && packet.size == size;
}
Outgoing status(Bytes parameters) {
  Outgoing with_error{0};
  with_error.add(parameters);
  return makeFrame(Instruction::kStatus, with_error.bytes());
}
bool writes(const Packet& packet, Address address, std::size_t size) {
  return packet.instruction == Instruction::kWrite && packet.size == 2 + size &&
         wordAt(packet.parameters(), 0) == address;
}

}  // namespace

std::optional<std::size_t> Format::sizeOf(Bytes bytes) {
  const std::size_t known = std::min(bytes.size(), kHead.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), kHead.begin())) return 0;
  if (bytes.size() < kInstructionAt) return std::nullopt;
  const std::size_t length = wordAt(bytes, kLengthAt);
  return length < 1 + kCrc ? 0 : kInstructionAt + length;
}

bool Format::isGood(Bytes frame) {
  return wordAt(frame, frame.size() - kCrc) == crcOf(frame.first(frame.size() - kCrc));
}

std::optional<Packet> parse(Bytes frame) {
  Packet packet{.id = frame[kIdAt], .instruction = static_cast<Instruction>(frame[kInstructionAt])};
  Bytes rest = frame.subspan(kParametersAt, frame.size() - kParametersAt - kCrc);
  if (packet.instruction == Instruction::kStatus) {
    if (rest.empty()) return std::nullopt;
    packet.error = rest[0];
  }
  const std::size_t first = packet.instruction == Instruction::kStatus ? 1 : 0;
  for (std::size_t i = first; i < rest.size(); ++i) {
    const bool stuffed = rest[i] == kHead[2] && endsLikeHead({packet.bytes.data(), packet.size});
    if (!stuffed) packet.bytes[packet.size++] = rest[i];
  }
  return packet;
}

Outgoing ping() { return makeFrame(Instruction::kPing, {}); }

Outgoing readTable() {
  Outgoing parameters;
  parameters.addLittle<2>(kMillis);
  parameters.addLittle<2>(kEnd - kMillis);
  return makeFrame(Instruction::kRead, parameters.bytes());
}

Outgoing beat(std::uint8_t heartbeat) {
  Outgoing parameters;
  parameters.addLittle<2>(kHeartbeat);
  parameters.addByte(heartbeat);
  return makeFrame(Instruction::kWrite, parameters.bytes());
}

Outgoing encodeSpeeds(double speed, double turn_rate) {
  constexpr double kMost = 1e6;
  const auto units = [&](double value) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(kPerUnit * value, -kMost, kMost)));
  };
  Outgoing parameters;
  parameters.addLittle<2>(kLinearSpeed);
  for (const std::uint32_t value : {units(speed), 0U, 0U, 0U, 0U, units(turn_rate)}) parameters.addLittle<4>(value);
  return makeFrame(Instruction::kWrite, parameters.bytes());
}

std::optional<Table> parseTable(const Packet& packet) {
  if (!isStatus(packet, kEnd - kMillis)) return std::nullopt;
  const auto at = [&](std::size_t address) { return longAt(packet.parameters(), address - kMillis); };
  const Table table{.millis = at(kMillis),
                    .battery = kVolts * at(kBattery),
                    .bumped = wordAt(packet.parameters(), kBumpers - kMillis) != 0,
                    .turn_rate = std::bit_cast<float>(at(kGyroZ)),
                    .counts = {at(kPositions), at(kPositions + 4)}};
  return std::isfinite(table.turn_rate) ? std::optional(table) : std::nullopt;
}

bool isPong(const Packet& packet) { return isStatus(packet, 3) && wordAt(packet.parameters(), 0) == kModel; }
bool isDone(const Packet& packet) { return isStatus(packet, 0) && packet.error == 0; }

Outgoing encodeTable(const Table& table) {
  std::array<std::uint8_t, kEnd - kMillis> bytes{};
  const auto put = [&](std::size_t address, std::uint32_t value) {
    little_endian::putWord(bytes, address - kMillis, static_cast<std::uint16_t>(value & 0xFFFF));
    little_endian::putWord(bytes, address - kMillis + 2, static_cast<std::uint16_t>(value >> 16));
  };
  put(kMillis, table.millis);
  bytes[kBumpers - kMillis] = table.bumped ? 1 : 0;
  put(kBattery, static_cast<std::uint32_t>(std::lround(table.battery / kVolts)));
  put(kGyroZ, std::bit_cast<std::uint32_t>(table.turn_rate));
  put(kPositions, table.counts[0]);
  put(kPositions + 4, table.counts[1]);
  return status(bytes);
}

Outgoing encodePong() {
  constexpr std::uint8_t kFirmware = 46;
  return status(std::array<std::uint8_t, 3>{kModel & 0xFF, kModel >> 8, kFirmware});
}
Outgoing encodeDone() { return status({}); }

std::optional<std::array<double, 2>> parseSpeeds(const Packet& packet) {
  if (!writes(packet, kLinearSpeed, 24)) return std::nullopt;
  const auto value = [&](std::size_t offset) {
    return static_cast<std::int32_t>(longAt(packet.parameters(), 2 + offset)) / kPerUnit;
  };
  return std::array{value(0), value(20)};
}

std::optional<std::uint8_t> parseBeat(const Packet& packet) {
  if (!writes(packet, kHeartbeat, 1)) return std::nullopt;
  return packet.bytes[2];
}

bool isForBoard(const Packet& packet) { return packet.id == kBoard && packet.instruction != Instruction::kStatus; }

}  // namespace slam::opencr
