// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/roboclaw.hpp"

#include <algorithm>
#include <string_view>

#include "firmware_if/slamd_base/base_frame.hpp"

namespace slam::roboclaw {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kHead = 2, kCrc = 2, kSpeedsSize = 8, kTimeoutSize = 1;  // [bytes]

std::uint16_t crcOf(Bytes bytes, std::uint16_t start = 0) {
  return slamd_base::crc16(bytes.data(), bytes.size(), start);
}
Outgoing headOf(std::uint8_t address, Command command) { return {address, static_cast<std::uint8_t>(command)}; }
/// An answer's checksum is over the request's head, too.
std::uint16_t answerCrc(std::uint8_t address, Command command, Bytes data) {
  return crcOf(data, crcOf(headOf(address, command).bytes()));
}
std::uint32_t wordAt(Bytes bytes, std::size_t offset, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[offset + i];
  return value;
}
Outgoing withCrc(Outgoing packet) {
  packet.addBig<2>(crcOf(packet.bytes()));
  return packet;
}
/// Whether this is a whole packet of that command, with its checksum.
bool isPacket(Bytes packet, Command command, std::size_t data) {
  return packet.size() == kHead + data + kCrc && packet[1] == static_cast<std::uint8_t>(command) &&
         wordAt(packet, kHead + data, kCrc) == crcOf(packet.first(kHead + data));
}
Outgoing answer(std::uint8_t address, Command command, Outgoing data) {
  data.addBig<2>(answerCrc(address, command, data.bytes()));
  return data;
}

}  // namespace

Outgoing askVersion(std::uint8_t address) { return headOf(address, Command::kVersion); }
Outgoing askCounts(std::uint8_t address) { return headOf(address, Command::kCounts); }

Outgoing encodeSpeeds(std::uint8_t address, const std::array<std::int32_t, 2>& speeds) {
  Outgoing out = headOf(address, Command::kSpeeds);
  for (const std::int32_t speed : speeds) out.addBig<4>(static_cast<std::uint32_t>(speed));
  return withCrc(out);
}

Outgoing encodeTimeout(std::uint8_t address, std::uint8_t tenths) {
  Outgoing out = headOf(address, Command::kTimeout);
  out.addByte(tenths);
  return withCrc(out);
}

std::optional<std::array<std::uint32_t, 2>> parseCounts(std::uint8_t address, Bytes bytes) {
  if (bytes.size() != kCountsSize) return std::nullopt;
  const Bytes data = bytes.first(kCountsSize - kCrc);
  if (wordAt(bytes, data.size(), kCrc) != answerCrc(address, Command::kCounts, data)) return std::nullopt;
  return std::array{wordAt(data, 0, 4), wordAt(data, 4, 4)};
}

bool endsWithVersion(std::uint8_t address, Bytes bytes) {
  constexpr std::size_t kShortest = 6;  // a letter or two, line feed, zero, checksum
  if (bytes.size() < kShortest) return false;
  const Bytes text = bytes.first(bytes.size() - kCrc);
  if (text[text.size() - 1] != 0 || text[text.size() - 2] != '\n') return false;
  const std::uint32_t crc = wordAt(bytes, text.size(), kCrc);
  const auto is_text = [](std::uint8_t byte) { return byte >= ' ' && byte <= '~'; };
  for (std::size_t size = 3; size <= std::min(text.size(), kLongestVersion - kCrc); ++size) {
    const Bytes end = text.last(size);
    if (!is_text(end[0])) return false;
    if (answerCrc(address, Command::kVersion, end) == crc) return true;
  }
  return false;
}

Outgoing encodeCounts(std::uint8_t address, const std::array<std::uint32_t, 2>& counts) {
  Outgoing data;
  for (const std::uint32_t count : counts) data.addBig<4>(count);
  return answer(address, Command::kCounts, data);
}

Outgoing encodeVersion(std::uint8_t address) {
  Outgoing data;
  for (const char c : std::string_view("USB Roboclaw 2x15a v4.1.34\n")) data.addByte(static_cast<std::uint8_t>(c));
  data.addByte(0);
  return answer(address, Command::kVersion, data);
}

std::size_t sizeOf(Bytes packet) {
  if (packet[0] < kFirstAddress || packet[0] > kLastAddress) return 0;
  if (packet.size() < kHead) return kHead;
  switch (static_cast<Command>(packet[1])) {
    case Command::kVersion:
    case Command::kCounts:
      return kHead;
    case Command::kSpeeds:
      return kHead + kSpeedsSize + kCrc;
    case Command::kTimeout:
      return kHead + kTimeoutSize + kCrc;
  }
  return 0;
}

std::optional<std::array<std::int32_t, 2>> parseSpeeds(Bytes packet) {
  if (!isPacket(packet, Command::kSpeeds, kSpeedsSize)) return std::nullopt;
  return std::array{static_cast<std::int32_t>(wordAt(packet, kHead, 4)),
                    static_cast<std::int32_t>(wordAt(packet, kHead + 4, 4))};
}

std::optional<std::uint8_t> parseTimeout(Bytes packet) {
  if (!isPacket(packet, Command::kTimeout, kTimeoutSize)) return std::nullopt;
  return packet[kHead];
}

}  // namespace slam::roboclaw
