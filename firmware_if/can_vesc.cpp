// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/can_vesc.hpp"

#include <initializer_list>

namespace slam::can::vesc {
namespace {

constexpr std::size_t kLong = 4, kShort = 2;  // [bytes]

bool isOf(int id, Packet packet, const Frame& frame, std::size_t size) {
  return frame.id == idOf(id, packet) && frame.extended && !frame.remote && !frame.error && frame.size >= size;
}

std::int32_t longAt(const Frame& frame, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < kLong; ++i) value = value << 8 | frame.data[offset + i];
  return static_cast<std::int32_t>(value);
}
std::int16_t shortAt(const Frame& frame, std::size_t offset) {
  return static_cast<std::int16_t>(frame.data[offset] << 8 | frame.data[offset + 1]);
}
void put(Frame& frame, std::uint32_t value, std::size_t bytes) {
  for (std::size_t i = bytes; i-- > 0;) frame.data[frame.size++] = static_cast<std::uint8_t>(value >> (8 * i));
}
Frame makeFrame(int id, Packet packet, std::int32_t first) {
  Frame frame{.id = idOf(id, packet), .extended = true};
  put(frame, static_cast<std::uint32_t>(first), kLong);
  return frame;
}
void putShorts(Frame& frame, std::initializer_list<std::int16_t> values) {
  for (const std::int16_t value : values) put(frame, static_cast<std::uint16_t>(value), kShort);
}

}  // namespace

Frame encode(int id, const Status& value) {
  Frame frame = makeFrame(id, Packet::kStatus, value.erpm);
  putShorts(frame, {value.current, value.duty});
  return frame;
}

std::optional<Status> parseStatus(int id, const Frame& frame) {
  if (!isOf(id, Packet::kStatus, frame, 8)) return std::nullopt;
  return Status{longAt(frame, 0), shortAt(frame, 4), shortAt(frame, 6)};
}

Frame encode(int id, const Status4& value) {
  Frame frame{.id = idOf(id, Packet::kStatus4), .extended = true};
  putShorts(frame, {value.transistors, value.motor, value.input_current, value.position});
  return frame;
}

std::optional<Status4> parseStatus4(int id, const Frame& frame) {
  if (!isOf(id, Packet::kStatus4, frame, 8)) return std::nullopt;
  return Status4{shortAt(frame, 0), shortAt(frame, 2), shortAt(frame, 4), shortAt(frame, 6)};
}

Frame encode(int id, const Status5& value) {
  Frame frame = makeFrame(id, Packet::kStatus5, value.tachometer);
  putShorts(frame, {value.voltage, 0});
  return frame;
}

std::optional<Status5> parseStatus5(int id, const Frame& frame) {
  if (!isOf(id, Packet::kStatus5, frame, 6)) return std::nullopt;
  return Status5{longAt(frame, 0), shortAt(frame, 4)};
}

Frame encodeSetRpm(int id, std::int32_t erpm) { return makeFrame(id, Packet::kSetRpm, erpm); }

std::optional<std::int32_t> parseSetRpm(int id, const Frame& frame) {
  if (!isOf(id, Packet::kSetRpm, frame, kLong)) return std::nullopt;
  return longAt(frame, 0);
}

}  // namespace slam::can::vesc
