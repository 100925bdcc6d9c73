// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

/// Words and singles in the little-endian bytes of a frame. The caller has checked that they fit.
namespace slam::little_endian {

using Bytes = std::span<const std::uint8_t>;

inline std::uint16_t wordAt(Bytes bytes, std::size_t offset) {
  return static_cast<std::uint16_t>(bytes[offset] | bytes[offset + 1] << 8);
}

inline void putWord(std::span<std::uint8_t> bytes, std::size_t offset, std::uint16_t value) {
  bytes[offset] = static_cast<std::uint8_t>(value & 0xFF);
  bytes[offset + 1] = static_cast<std::uint8_t>(value >> 8);
}

inline float floatAt(Bytes bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | bytes[offset + i];
  return std::bit_cast<float>(value);
}

inline void putFloat(std::span<std::uint8_t> bytes, std::size_t offset, float value) {
  auto bits = std::bit_cast<std::uint32_t>(value);
  for (std::size_t i = 0; i < 4; ++i, bits >>= 8) bytes[offset + i] = static_cast<std::uint8_t>(bits);
}

template <std::size_t N>
void putFloats(std::span<std::uint8_t> bytes, std::size_t offset, const std::array<float, N>& values) {
  for (std::size_t i = 0; i < N; ++i) putFloat(bytes, offset + 4 * i, values[i]);
}

/// @return whether all are finite
template <std::size_t N>
bool readFloats(Bytes bytes, std::size_t offset, std::array<float, N>& out) {
  for (std::size_t i = 0; i < N; ++i) out[i] = floatAt(bytes, offset + 4 * i);
  return std::all_of(out.begin(), out.end(), [](float value) { return std::isfinite(value); });
}

}  // namespace slam::little_endian
