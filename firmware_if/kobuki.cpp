// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/kobuki.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_if/little_endian.hpp"

namespace slam::kobuki {
namespace {

using Bytes = std::span<const std::uint8_t>;
using little_endian::wordAt;

constexpr std::uint8_t kFirst = 0xAA, kSecond = 0x55;
constexpr std::size_t kHead = 3;  // with the length
constexpr std::uint8_t kCore = 1, kInertia = 4, kBaseControl = 1;
constexpr std::size_t kCoreSize = 15, kInertiaSize = 7, kBaseControlSize = 4;
constexpr std::uint8_t kDrops = 0x03;
constexpr double kVoltsPerCount = 0.1;
constexpr double kMillimetres = 1000.0;  // in a metre

std::uint8_t xorOf(Bytes bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum ^= byte;
  return sum;
}

/// The sub-payload with that id in a frame. @return empty: it has none, or one of another size, or is damaged
Bytes find(Bytes frame, std::uint8_t id, std::size_t size) {
  Bytes rest = frame.subspan(kHead, frame.size() - kHead - 1), found;
  while (!rest.empty()) {
    if (rest.size() < 2 || rest.size() < 2U + rest[1]) return {};
    if (rest[0] == id && rest[1] == size) found = rest.subspan(2, size);
    rest = rest.subspan(2U + rest[1]);
  }
  return found;
}

Outgoing finish(Outgoing payload) {
  Outgoing out{kFirst, kSecond, static_cast<std::uint8_t>(payload.size())};
  out.add(payload.bytes());
  out.addByte(xorOf(out.bytes().subspan(2)));
  return out;
}

std::int16_t limited(double value) {
  constexpr double kMost = 32767.0;
  return static_cast<std::int16_t>(std::clamp(std::round(value), -kMost, kMost));
}

}  // namespace

std::optional<std::size_t> Format::sizeOf(Bytes bytes) {
  if (bytes[0] != kFirst || (bytes.size() > 1 && bytes[1] != kSecond)) return 0;
  if (bytes.size() < kHead) return std::nullopt;
  return bytes[2] == 0 ? 0 : kHead + bytes[2] + 1;
}

bool Format::isGood(Bytes frame) { return xorOf(frame.subspan(2)) == 0; }

std::optional<Feedback> parseFeedback(Bytes frame) {
  const Bytes core = find(frame, kCore, kCoreSize);
  if (core.empty()) return std::nullopt;
  Feedback feedback{.stamp = wordAt(core, 0),
                    .bumped = core[2] != 0,
                    .dropped = (core[3] & kDrops) != 0,
                    .cliff = core[4] != 0,
                    .counts = {wordAt(core, 5), wordAt(core, 7)},
                    .battery = kVoltsPerCount * core[13],
                    .turn_rate = std::nullopt};
  if (const Bytes inertia = find(frame, kInertia, kInertiaSize); !inertia.empty())
    feedback.turn_rate = static_cast<std::int16_t>(wordAt(inertia, 2));
  return feedback;
}

Outgoing encodeFeedback(const Feedback& feedback) {
  Outgoing out{kCore, static_cast<std::uint8_t>(kCoreSize)};
  out.addLittle<2>(feedback.stamp);
  out.addByte(feedback.bumped ? 1 : 0);
  out.addByte(feedback.dropped ? kDrops : 0);
  out.addByte(feedback.cliff ? 1 : 0);
  for (const std::uint16_t count : feedback.counts) out.addLittle<2>(count);
  for (int unused = 0; unused < 4; ++unused) out.addByte(0);  // PWM of both wheels, buttons, charger
  out.addByte(static_cast<std::uint8_t>(std::clamp(std::round(feedback.battery / kVoltsPerCount), 0.0, 255.0)));
  out.addByte(0);  // overcurrent
  if (feedback.turn_rate) {
    out.addByte(kInertia);
    out.addByte(static_cast<std::uint8_t>(kInertiaSize));
    out.addLittle<2>(0);  // angle
    out.addLittle<2>(static_cast<std::uint16_t>(*feedback.turn_rate));
    out.addLittle<3>(0);
  }
  return finish(out);
}

BaseCommand commandOf(double speed, double turn_rate) {
  constexpr double kWidest = 32767.0;                      // [mm] of a radius; a wider one is straight
  constexpr double kSmall = 1e-4;                          // [m/s], [rad/s] below: none, as its maker's driver has it
  const double radius = kMillimetres * speed / turn_rate;  // [mm]
  if (std::abs(turn_rate) < kSmall || std::abs(radius) > kWidest) return {limited(kMillimetres * speed), 0};
  if (std::abs(speed) < kSmall || std::abs(radius) <= 1.0) return {limited(kMillimetres * kHalfTrack * turn_rate), 1};
  const double outer = radius + std::copysign(kMillimetres * kHalfTrack, radius);
  return {limited(outer * turn_rate), limited(radius)};
}

std::array<double, 2> twistOf(const BaseCommand& command) {
  const double speed = command.speed / kMillimetres, radius = command.radius / kMillimetres;
  if (command.radius == 0) return {speed, 0.0};
  if (command.radius == 1) return {0.0, speed / kHalfTrack};
  const double turn_rate = speed / (radius + std::copysign(kHalfTrack, radius));
  return {radius * turn_rate, turn_rate};
}

Outgoing encode(const BaseCommand& command) {
  Outgoing out{kBaseControl, static_cast<std::uint8_t>(kBaseControlSize)};
  out.addLittle<2>(static_cast<std::uint16_t>(command.speed));
  out.addLittle<2>(static_cast<std::uint16_t>(command.radius));
  return finish(out);
}

std::optional<BaseCommand> parseCommand(Bytes frame) {
  const Bytes data = find(frame, kBaseControl, kBaseControlSize);
  if (data.empty()) return std::nullopt;
  return BaseCommand{static_cast<std::int16_t>(wordAt(data, 0)), static_cast<std::int16_t>(wordAt(data, 2))};
}

}  // namespace slam::kobuki
