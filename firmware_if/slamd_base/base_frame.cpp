// SPDX-License-Identifier: BSD-3-Clause
#include "base_frame.hpp"

namespace slamd_base {
namespace {

const uint16_t kStart = 0xFFFF;
enum : uint8_t { kTypeAt = 2, kLengthAt = 3, kStateSize = 20, kSpeedsSize = 9, kCrcSize = 2 };

class Writer {
 public:
  Writer(uint8_t* out, uint8_t type, uint8_t length) : begin_(out), out_(out) {
    put(kFirst, 1);
    put(kSecond, 1);
    put(type, 1);
    put(length, 1);
  }
  void put(uint32_t value, uint8_t bytes) {
    for (; bytes > 0; --bytes, value >>= 8) *out_++ = static_cast<uint8_t>(value & 0xFF);
  }
  uint8_t end() {
    put(crc16(begin_ + kTypeAt, static_cast<size_t>(out_ - begin_) - kTypeAt, kStart), kCrcSize);
    return static_cast<uint8_t>(out_ - begin_);
  }

 private:
  uint8_t* begin_;
  uint8_t* out_;
};

uint32_t wordAt(const uint8_t* bytes, uint8_t size) {
  uint32_t value = 0;
  while (size > 0) value = value << 8 | bytes[--size];
  return value;
}
int32_t signedAt(const uint8_t* bytes) { return static_cast<int32_t>(wordAt(bytes, 4)); }

bool isOf(const uint8_t* frame, uint8_t type, uint8_t size) {
  return frame[kTypeAt] == type && frame[kLengthAt] >= size;
}

}  // namespace

uint16_t crc16(const uint8_t* bytes, size_t size, uint16_t start, uint16_t polynomial) {
  uint16_t crc = start;
  for (; size > 0; --size, ++bytes) {
    crc = static_cast<uint16_t>(crc ^ (static_cast<uint16_t>(*bytes) << 8));
    for (uint8_t bit = 0; bit < 8; ++bit) {
      const bool top = (crc & 0x8000) != 0;
      crc = static_cast<uint16_t>(crc << 1);
      if (top) crc = static_cast<uint16_t>(crc ^ polynomial);
    }
  }
  return crc;
}

uint8_t encodeState(const State& state, uint8_t* out) {
  Writer writer(out, kStateType, kStateSize);
  writer.put(state.stamp, 4);
  for (uint8_t side = 0; side < 2; ++side) writer.put(static_cast<uint32_t>(state.counts[side]), 4);
  writer.put(static_cast<uint32_t>(state.turn_rate), 4);
  writer.put(state.battery, 2);
  writer.put(state.speeds, 1);
  writer.put(state.flags, 1);
  return writer.end();
}

uint8_t encodeSpeeds(const Speeds& speeds, uint8_t* out) {
  Writer writer(out, kSpeedsType, kSpeedsSize);
  writer.put(speeds.number, 1);
  for (uint8_t side = 0; side < 2; ++side) writer.put(static_cast<uint32_t>(speeds.speeds[side]), 4);
  return writer.end();
}

bool parseState(const uint8_t* frame, State* state) {
  if (!isOf(frame, kStateType, kStateSize)) return false;
  const uint8_t* payload = frame + kHead;
  state->stamp = wordAt(payload, 4);
  state->counts[0] = signedAt(payload + 4);
  state->counts[1] = signedAt(payload + 8);
  state->turn_rate = signedAt(payload + 12);
  state->battery = static_cast<uint16_t>(wordAt(payload + 16, 2));
  state->speeds = payload[18];
  state->flags = payload[19];
  return true;
}

bool parseSpeeds(const uint8_t* frame, Speeds* speeds) {
  if (!isOf(frame, kSpeedsType, kSpeedsSize)) return false;
  speeds->number = frame[kHead];
  speeds->speeds[0] = signedAt(frame + kHead + 1);
  speeds->speeds[1] = signedAt(frame + kHead + 5);
  return true;
}

uint8_t Receiver::search() {
  while (size_ > 0) {
    const bool begins = held_[0] == kFirst && (size_ < 2 || held_[1] == kSecond);
    if (!begins || (size_ > kLengthAt && held_[kLengthAt] > kMostPayload)) {
      drop(1);
      continue;
    }
    if (size_ <= kLengthAt) return 0;
    const uint8_t payload_end = static_cast<uint8_t>(kHead + held_[kLengthAt]);
    if (size_ < payload_end + kCrcSize) return 0;
    const uint16_t crc = crc16(held_ + kTypeAt, static_cast<size_t>(payload_end - kTypeAt), kStart);
    if (wordAt(held_ + payload_end, kCrcSize) == crc) return static_cast<uint8_t>(payload_end + kCrcSize);
    ++damaged_;
    drop(1);
  }
  return 0;
}

void Receiver::drop(uint8_t count) {
  size_ = static_cast<uint8_t>(size_ - count);
  memmove(held_, held_ + count, size_);
}

}  // namespace slamd_base
