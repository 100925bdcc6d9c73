// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/vesc/vesc_packets.hpp"

#include <string_view>

#include "firmware_if/slamd_base/base_frame.hpp"

namespace slam::vesc {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kFirst = 0x02, kLast = 0x03;
constexpr std::size_t kSelection = 4, kSmallest = 1;  // [bytes]

// Bits of a selection. One more that is not used tells the turns apart.
constexpr std::uint32_t kVoltage = 1U << 8, kTachometer = 1U << 13, kFault = 1U << 15, kId = 1U << 17;
constexpr std::uint32_t kUsed = kVoltage | kTachometer | kFault | kId, kOddOnly = 1U << 0;  // the latter: temperature
constexpr std::uint32_t selectionOf(Turn turn) { return turn == Turn::kOdd ? kUsed | kOddOnly : kUsed; }
constexpr std::size_t kTemperature = 2, kValues = 2 + 4 + 1 + 1;  // [bytes] of these fields

Outgoing frameOf(Bytes payload) {
  Outgoing out{kFirst, static_cast<std::uint8_t>(payload.size())};
  out.add(payload);
  out.addBig<2>(slamd_base::crc16(payload.data(), payload.size(), 0));
  out.addByte(kLast);
  return out;
}
std::uint32_t numberAt(Bytes bytes, std::size_t offset, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[offset + i];
  return value;
}
bool isCommand(Bytes payload, Command command) {
  return !payload.empty() && payload[0] == static_cast<std::uint8_t>(command);
}
Outgoing payload(Command command) { return {static_cast<std::uint8_t>(command)}; }

}  // namespace

std::optional<std::size_t> Format::sizeOf(Bytes bytes) {
  if (bytes[0] != kFirst) return 0;
  if (bytes.size() < kHead) return std::nullopt;
  return bytes[1] < kSmallest || bytes[1] > kMost ? 0 : kHead + bytes[1] + kTail;
}

bool Format::isGood(Bytes frame) {
  const Bytes payload = payloadOf(frame);
  return frame.back() == kLast &&
         numberAt(frame, kHead + payload.size(), 2) == slamd_base::crc16(payload.data(), payload.size(), 0);
}

Bytes payloadOf(Bytes frame) { return frame.subspan(Format::kHead, frame.size() - Format::kHead - Format::kTail); }

Outgoing askVersion() { return frameOf(payload(Command::kVersion).bytes()); }

Outgoing askValues(Turn turn) {
  Outgoing out = payload(Command::kSelectedValues);
  out.addBig<kSelection>(selectionOf(turn));
  return frameOf(out.bytes());
}

Outgoing setRpm(std::int32_t erpm) {
  Outgoing out = payload(Command::kSetRpm);
  out.addBig<4>(static_cast<std::uint32_t>(erpm));
  return frameOf(out.bytes());
}

Outgoing forward(std::uint8_t id, const Outgoing& packet) {
  Outgoing out = payload(Command::kForward);
  out.addByte(id);
  out.add(payloadOf(packet.bytes()));
  return frameOf(out.bytes());
}

std::optional<Values> parseValues(Bytes frame) {
  const Bytes bytes = payloadOf(frame);
  if (!isCommand(bytes, Command::kSelectedValues) || bytes.size() < 1 + kSelection) return std::nullopt;
  const std::uint32_t selection = numberAt(bytes, 1, kSelection);
  const Turn turn = (selection & kOddOnly) != 0 ? Turn::kOdd : Turn::kEven;
  std::size_t at = 1 + kSelection + (turn == Turn::kOdd ? kTemperature : 0);
  if (selection != selectionOf(turn) || bytes.size() != at + kValues) return std::nullopt;
  const auto next = [&](std::size_t size) { return numberAt(bytes, (at += size) - size, size); };
  Values values{.turn = turn};
  values.voltage = static_cast<std::int16_t>(next(2));
  values.tachometer = static_cast<std::int32_t>(next(4));
  values.fault = static_cast<std::uint8_t>(next(1));
  values.id = static_cast<std::uint8_t>(next(1));
  return values;
}

bool isVersion(Bytes frame) {
  constexpr std::size_t kNumbers = 3;  // major and minor, and at least the end of a name
  return isCommand(payloadOf(frame), Command::kVersion) && payloadOf(frame).size() > kNumbers;
}

Outgoing encodeVersion() {
  Outgoing out = payload(Command::kVersion);
  out.add(std::array<std::uint8_t, 2>{6, 2});
  for (const char c : std::string_view("60_MK6")) out.addByte(static_cast<std::uint8_t>(c));
  out.addByte(0);
  out.add(std::array<std::uint8_t, 12>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  return frameOf(out.bytes());
}

Outgoing encodeValues(const Values& values) {
  constexpr std::uint32_t kWarm = 305;  // [0.1 deg C]
  Outgoing out = payload(Command::kSelectedValues);
  out.addBig<kSelection>(selectionOf(values.turn));
  if (values.turn == Turn::kOdd) out.addBig<kTemperature>(kWarm);
  out.addBig<2>(static_cast<std::uint16_t>(values.voltage));
  out.addBig<4>(static_cast<std::uint32_t>(values.tachometer));
  out.addByte(values.fault);
  out.addByte(values.id);
  return frameOf(out.bytes());
}

std::optional<Turn> parseAskValues(Bytes payload) {
  if (!isCommand(payload, Command::kSelectedValues) || payload.size() != 1 + kSelection) return std::nullopt;
  const std::uint32_t selection = numberAt(payload, 1, kSelection);
  for (const Turn turn : {Turn::kEven, Turn::kOdd}) {
    if (selection == selectionOf(turn)) return turn;
  }
  return std::nullopt;
}

std::optional<std::int32_t> parseSetRpm(Bytes payload) {
  if (!isCommand(payload, Command::kSetRpm) || payload.size() != 5) return std::nullopt;
  return static_cast<std::int32_t>(numberAt(payload, 1, 4));
}

bool isAskVersion(Bytes payload) { return isCommand(payload, Command::kVersion) && payload.size() == 1; }

Forwarded parseForward(Bytes payload) {
  if (!isCommand(payload, Command::kForward) || payload.size() < 3) return {};
  return {payload[1], payload.subspan(2)};
}

}  // namespace slam::vesc
