// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/create_oi.hpp"

#include <algorithm>
#include <numeric>

namespace slam::create_oi {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kStart = 128, kSafe = 131, kDriveDirect = 145, kStream = 148, kPauseStream = 150, kStop = 173;
constexpr std::uint8_t kHeader = 0x13;

constexpr std::uint8_t kBumpsAndDrops = 7, kVoltage = 22, kChargers = 34, kMode = 35, kRequestedRight = 41,
                       kRequestedLeft = 42, kLeftCounts = 43, kRightCounts = 44;
constexpr std::uint8_t kBumps = 0x03, kDrops = 0x0C;  // right and left each

/// A packet of the stream, in the order of asking.
struct Packet {
  std::uint8_t id;
  std::size_t size;
};
constexpr std::array kStreamed = {Packet{kBumpsAndDrops, 1}, Packet{kVoltage, 2},        Packet{kChargers, 1},
                                  Packet{kMode, 1},          Packet{kRequestedRight, 2}, Packet{kRequestedLeft, 2},
                                  Packet{kLeftCounts, 2},    Packet{kRightCounts, 2}};
constexpr std::size_t kContent = [] {
  std::size_t size = 0;
  for (const Packet& packet : kStreamed) size += 1 + packet.size;
  return size;
}();

std::uint8_t sumOf(Bytes bytes) { return std::accumulate(bytes.begin(), bytes.end(), std::uint8_t{0}); }

std::uint16_t wordAt(Bytes bytes, std::size_t at) { return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]); }

}  // namespace

std::optional<std::size_t> StreamFormat::sizeOf(Bytes bytes) {
  if (bytes[0] != kHeader) return 0;
  if (bytes.size() < 2) return std::nullopt;
  return bytes[1] + 3U;
}

bool StreamFormat::isGood(Bytes frame) { return sumOf(frame) == 0; }

std::optional<Sensors> parseStream(Bytes frame) {
  if (frame.size() != kContent + 3 || frame[1] != kContent) return std::nullopt;
  Sensors sensors;
  std::size_t at = 2;
  for (const Packet& packet : kStreamed) {
    if (frame[at] != packet.id) return std::nullopt;
    const std::size_t data = at + 1;
    at += 1 + packet.size;
    switch (packet.id) {
      case kBumpsAndDrops:
        sensors.bumped = (frame[data] & kBumps) != 0;
        sensors.dropped = (frame[data] & kDrops) != 0;
        break;
      case kVoltage:
        sensors.voltage = wordAt(frame, data);
        break;
      case kChargers:
        sensors.plugged_in = frame[data] != 0;
        break;
      case kMode:
        if (frame[data] > static_cast<std::uint8_t>(Mode::kFull)) return std::nullopt;
        sensors.mode = static_cast<Mode>(frame[data]);
        break;
      case kRequestedRight:
        sensors.requested[1] = static_cast<std::int16_t>(wordAt(frame, data));
        break;
      case kRequestedLeft:
        sensors.requested[0] = static_cast<std::int16_t>(wordAt(frame, data));
        break;
      case kLeftCounts:
        sensors.counts[0] = wordAt(frame, data);
        break;
      default:
        sensors.counts[1] = wordAt(frame, data);
    }
  }
  return sensors;
}

Outgoing encodeStream(const Sensors& sensors) {
  Outgoing out{kHeader, static_cast<std::uint8_t>(kContent)};
  const auto word = [](std::int16_t value) { return static_cast<std::uint16_t>(value); };
  out.addByte(kBumpsAndDrops);
  out.addByte(static_cast<std::uint8_t>((sensors.dropped ? kDrops : 0) | (sensors.bumped ? kBumps : 0)));
  out.addByte(kVoltage);
  out.addBig<2>(sensors.voltage);
  out.addByte(kChargers);
  out.addByte(sensors.plugged_in ? 1 : 0);
  out.addByte(kMode);
  out.addByte(static_cast<std::uint8_t>(sensors.mode));
  out.addByte(kRequestedRight);
  out.addBig<2>(word(sensors.requested[1]));
  out.addByte(kRequestedLeft);
  out.addBig<2>(word(sensors.requested[0]));
  out.addByte(kLeftCounts);
  out.addBig<2>(sensors.counts[0]);
  out.addByte(kRightCounts);
  out.addBig<2>(sensors.counts[1]);
  out.addByte(static_cast<std::uint8_t>(-sumOf(out.bytes())));
  return out;
}

Outgoing start() { return {kStart}; }
Outgoing stop() { return {kStop}; }
Outgoing enterSafe() { return {kSafe}; }

Outgoing askForStream() {
  Outgoing out{kStream, static_cast<std::uint8_t>(kStreamed.size())};
  for (const Packet& packet : kStreamed) out.addByte(packet.id);
  return out;
}

Outgoing pauseStream() { return {kPauseStream, 0}; }

Outgoing driveDirect(int left, int right) {
  constexpr int kMost = static_cast<int>(1000.0 * kFastest);  // [mm/s]
  Outgoing out{kDriveDirect};
  out.addBig<2>(static_cast<std::uint32_t>(std::clamp(right, -kMost, kMost)));
  out.addBig<2>(static_cast<std::uint32_t>(std::clamp(left, -kMost, kMost)));
  return out;
}

}  // namespace slam::create_oi
