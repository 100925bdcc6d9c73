// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace slam {

static_assert(std::endian::native == std::endian::little, "stored maps are little-endian");

/// Appends numbers to a string of bytes.
class BinaryWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    bytes_.append(bytes, sizeof(T));
  }
  void putBytes(std::string_view bytes) { bytes_.append(bytes); }
  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads them back. @throws std::runtime_error at the end
class BinaryReader {
 public:
  explicit BinaryReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, getBytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view getBytes(std::size_t count) {
    if (count > bytes_.size()) throw std::runtime_error("ends too early");
    const std::string_view part = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return part;
  }
  /// A count of things of at least `size` bytes each, which must all be there.
  std::size_t getCount(std::size_t size) {
    const auto count = get<std::uint64_t>();
    if (count > bytes_.size() / size) throw std::runtime_error("counts more than it holds");
    return static_cast<std::size_t>(count);
  }
  /// All that is left.
  std::string_view rest() { return getBytes(bytes_.size()); }
  bool atEnd() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

}  // namespace slam
