// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace slam {

/// Values one behind the other, little-endian unless said, each checked against the end; behind it all are 0 and ok()
/// is false.
class WireReader {
 public:
  /// @param aligned each number lies at a multiple of its own size, counted from the beginning (CDR)
  /// @param big_endian the highest byte lies first (LCM)
  explicit WireReader(std::span<const std::uint8_t> bytes, bool aligned = false, bool big_endian = false)
      : bytes_(bytes), aligned_(aligned), big_endian_(big_endian) {}

  template <typename T>
  T number() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    if (aligned_) at_ += (sizeof(T) - at_ % sizeof(T)) % sizeof(T);
    const auto part = take(sizeof(T));
    std::array<std::uint8_t, sizeof(T)> copy{};
    std::copy(part.begin(), part.end(), copy.begin());
    if (big_endian_) std::reverse(copy.begin(), copy.end());
    std::memcpy(&value, copy.data(), sizeof(T));
    return value;
  }
  /// Empty where fewer are left.
  std::span<const std::uint8_t> take(std::size_t count) {
    if (!ok_ || at_ > bytes_.size() || count > bytes_.size() - at_) {
      ok_ = false;
      return {};
    }
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }
  /// A text behind its size in 32 bits.
  std::string_view text() {
    const auto part = take(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }
  /// How many items follow, of at least so many bytes each.
  std::uint32_t count(std::size_t least_bytes) {
    const auto n = number<std::uint32_t>();
    if (n > left() / least_bytes) ok_ = false;
    return ok_ ? n : 0;
  }
  template <typename T>
  void skip(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) number<T>();
  }
  void fail() { ok_ = false; }
  bool ok() const { return ok_; }
  std::size_t left() const { return ok_ && at_ <= bytes_.size() ? bytes_.size() - at_ : 0; }
  std::size_t position() const { return at_; }

 private:
  std::span<const std::uint8_t> bytes_;
  bool aligned_, big_endian_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace slam
