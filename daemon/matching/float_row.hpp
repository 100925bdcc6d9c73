// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace slam {

/// Four numbers that a processor computes with at once: SSE2 and NEON have the same width, and every operation here
/// rounds alike on both. A comparison gives an IntRow of 0 (false) and -1 (true).
using FloatRow = float __attribute__((vector_size(16)));
using FloatPair = float __attribute__((vector_size(8)));
using DoublePair = double __attribute__((vector_size(16)));
using IntRow = std::int32_t __attribute__((vector_size(16)));
constexpr std::size_t kLanes = 4;

inline FloatRow rowOf(double value) {
  const auto single = static_cast<float>(value);
  return FloatRow{single, single, single, single};
}
/// @return value where the mask is true, otherwise 0
inline FloatRow where(IntRow mask, FloatRow value) {
  return std::bit_cast<FloatRow>(std::bit_cast<IntRow>(value) & mask);
}
inline FloatRow choose(IntRow mask, FloatRow yes, FloatRow no) {
  return std::bit_cast<FloatRow>((std::bit_cast<IntRow>(yes) & mask) | (std::bit_cast<IntRow>(no) & ~mask));
}
inline FloatPair singles(DoublePair pair) { return __builtin_convertvector(pair, FloatPair); }
/// @param offset [bytes] into the object, where four numbers lie
inline FloatRow loadRow(const auto& object, std::size_t offset = 0) {
  FloatRow row;
  std::memcpy(&row, reinterpret_cast<const char*>(&object) + offset, sizeof(row));
  return row;
}
/// Four pairs as columns: the first of each becomes the first row.
inline void pairsOf(const std::array<FloatPair, kLanes>& pairs, FloatRow& first, FloatRow& second) {
  const FloatRow a = loadRow(pairs), b = loadRow(pairs, sizeof(FloatRow));
  first = __builtin_shufflevector(a, b, 0, 2, 4, 6);
  second = __builtin_shufflevector(a, b, 1, 3, 5, 7);
}
inline bool any(IntRow mask) { return ((mask[0] | mask[1]) | (mask[2] | mask[3])) != 0; }
inline double sumOf(FloatRow row) { return static_cast<double>((row[0] + row[1]) + (row[2] + row[3])); }
/// @return in how many lanes these are true, where each element of the sum had 1 taken off for a true lane
inline int countOf(IntRow sum) { return -((sum[0] + sum[1]) + (sum[2] + sum[3])); }

/// Four rows as columns: what was the first element of each becomes the first row.
inline void transpose(FloatRow& a, FloatRow& b, FloatRow& c, FloatRow& d) {
  const FloatRow ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const FloatRow ba = __builtin_shufflevector(a, b, 2, 6, 3, 7), dc = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  a = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  c = __builtin_shufflevector(ba, dc, 0, 1, 4, 5);
  d = __builtin_shufflevector(ba, dc, 2, 3, 6, 7);
}

}  // namespace slam
