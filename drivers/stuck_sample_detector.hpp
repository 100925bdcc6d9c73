// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>

namespace slam {

/// FNV-1a of bytes, eight at a time: equal for equal data, and for next to nothing else.
inline std::uint64_t digestOf(std::span<const std::uint8_t> bytes) {
  std::uint64_t digest = 0xCBF29CE484222325ULL;
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t size = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), size);
    digest = (digest ^ word) * 0x100000001B3ULL;
    digest ^= digest >> 29;
    bytes = bytes.subspan(size);
  }
  return digest;
}

/// Notices a sensor that shows the same thing again and again, to the last bit, as none does whose values have noise.
class StuckSampleDetector {
 public:
  /// @param most times in a row that may be chance
  explicit StuckSampleDetector(int most) : most_(most) {}

  /// @param digest of what the sensor shows now @return whether it is stuck
  bool isStuck(std::uint64_t digest) {
    repeats_ = digest == last_ ? repeats_ + 1 : 0;
    last_ = digest;
    return repeats_ >= most_;
  }

 private:
  int most_, repeats_ = 0;
  std::uint64_t last_ = 0;
};

}  // namespace slam
