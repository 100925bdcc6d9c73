// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <span>
#include <string>
#include <type_traits>

namespace slam::fuzz {

using Bytes = std::span<const std::uint8_t>;
inline std::string textOf(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

/// Ends the run as a crash does, with the property that did not hold.
[[noreturn]] inline void fail(const char* property, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, property);
  std::abort();
}

/// What the input decides, taken off its front; zeros behind its end.
class Input {
 public:
  explicit Input(Bytes bytes) : bytes_(bytes) {}

  template <typename T>
  T take() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    const Bytes part = takeBytes(sizeof(T));
    if (!part.empty()) std::memcpy(&value, part.data(), part.size());
    return value;
  }
  Bytes takeBytes(std::size_t count) {
    const Bytes part = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(part.size());
    return part;
  }
  Bytes rest() { return takeBytes(bytes_.size()); }
  bool atEnd() const { return bytes_.empty(); }

 private:
  Bytes bytes_;
};

}  // namespace slam::fuzz

#define FUZZ_CHECK(property) \
  if (!(property)) slam::fuzz::fail(#property, __FILE__, __LINE__)

/// Also where the property throws.
#define FUZZ_CHECK_NO_THROW(property)                   \
  try {                                                 \
    FUZZ_CHECK(property);                               \
  } catch (const std::exception& error) {               \
    slam::fuzz::fail(error.what(), __FILE__, __LINE__); \
  }
