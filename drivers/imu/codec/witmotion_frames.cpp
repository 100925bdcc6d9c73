// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/codec/witmotion_frames.hpp"

#include "firmware_if/little_endian.hpp"

namespace slam::witmotion {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kHead = 0x55, kFirstType = 0x50, kLastType = 0x5F;

std::uint8_t sumOf(Bytes frame) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : frame.first(kFrameSize - 1)) sum = static_cast<std::uint8_t>(sum + byte);
  return sum;
}

}  // namespace

std::optional<std::size_t> Format::sizeOf(Bytes bytes) {
  const bool typed = bytes.size() < 2 || (bytes[1] >= kFirstType && bytes[1] <= kLastType);
  return bytes[0] == kHead && typed ? kFrameSize : 0;
}

bool Format::isGood(Bytes frame) { return sumOf(frame) == frame[kFrameSize - 1]; }

Frame parse(Bytes frame) {
  Frame out{static_cast<Type>(frame[1])};
  for (std::size_t i = 0; i < out.raw.size(); ++i)
    out.raw[i] = static_cast<std::int16_t>(little_endian::wordAt(frame, 2 + 2 * i));
  return out;
}

std::array<std::uint8_t, kFrameSize> encode(const Frame& frame) {
  std::array<std::uint8_t, kFrameSize> bytes{kHead, static_cast<std::uint8_t>(frame.type)};
  for (std::size_t i = 0; i < frame.raw.size(); ++i)
    little_endian::putWord(bytes, 2 + 2 * i, static_cast<std::uint16_t>(frame.raw[i]));
  bytes[kFrameSize - 1] = sumOf(bytes);
  return bytes;
}

}  // namespace slam::witmotion
