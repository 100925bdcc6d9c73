// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/codec/bno08x_frames.hpp"

#include "firmware_if/little_endian.hpp"

namespace slam::bno08x {
namespace {

using Bytes = std::span<const std::uint8_t>;
using little_endian::putWord;
using little_endian::wordAt;

constexpr std::uint8_t kHead = 0xAA;
constexpr std::size_t kIndexAt = 2, kAnglesAt = 3, kAccelerationAt = 9;

std::uint8_t sumOf(Bytes frame) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : frame.subspan(kIndexAt, kFrameSize - kIndexAt - 1))
    sum = static_cast<std::uint8_t>(sum + byte);
  return sum;
}

}  // namespace

std::optional<std::size_t> Format::sizeOf(Bytes bytes) {
  return bytes[0] == kHead && (bytes.size() < 2 || bytes[1] == kHead) ? kFrameSize : 0;
}

bool Format::isGood(Bytes frame) { return sumOf(frame) == frame[kFrameSize - 1]; }

Frame parse(Bytes frame) {
  const auto signedAt = [&](std::size_t offset) { return static_cast<std::int16_t>(wordAt(frame, offset)); };
  return {.index = frame[kIndexAt],
          .yaw = signedAt(kAnglesAt),
          .pitch = signedAt(kAnglesAt + 2),
          .roll = signedAt(kAnglesAt + 4),
          .acceleration = {signedAt(kAccelerationAt), signedAt(kAccelerationAt + 2), signedAt(kAccelerationAt + 4)}};
}

std::array<std::uint8_t, kFrameSize> encode(const Frame& frame) {
  std::array<std::uint8_t, kFrameSize> bytes{kHead, kHead, frame.index};
  std::size_t at = kAnglesAt;
  for (const std::int16_t value :
       {frame.yaw, frame.pitch, frame.roll, frame.acceleration[0], frame.acceleration[1], frame.acceleration[2]}) {
    putWord(bytes, at, static_cast<std::uint16_t>(value));
    at += 2;
  }
  bytes[kFrameSize - 1] = sumOf(bytes);
  return bytes;
}

}  // namespace slam::bno08x
