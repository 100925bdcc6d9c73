// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>

namespace slam {

/// Bytes of a command to a device, by value: no heap. What does not fit is left out; kMost is above the longest
/// command.
class Outgoing {
 public:
  static constexpr std::size_t kMost = 160;

  Outgoing() = default;
  Outgoing(std::initializer_list<std::uint8_t> bytes) { add(std::span(bytes.begin(), bytes.size())); }

  void add(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) addByte(byte);
  }
  void addByte(std::uint8_t byte) {
    if (size_ < kMost) bytes_[size_++] = byte;
  }
  /// The lowest `Size` bytes of a number, the highest of them first.
  template <int Size>
  void addBig(std::uint32_t value) {
    for (int i = Size - 1; i >= 0; --i) addByte(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  /// The same, the lowest byte first.
  template <int Size>
  void addLittle(std::uint32_t value) {
    for (int i = 0; i < Size; ++i) addByte(static_cast<std::uint8_t>(value >> (8 * i)));
  }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::uint8_t operator[](std::size_t i) const { return bytes_[i]; }
  std::span<const std::uint8_t> bytes() const { return {bytes_.data(), size_}; }

 private:
  std::array<std::uint8_t, kMost> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace slam
