// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace slam {

/// Looks for a text among bytes; an empty one never comes. The text must not begin again within itself but for its
/// first character.
class TextWatch {
 public:
  explicit constexpr TextWatch(std::string_view text) : text_(text) {}
  /// @return true with the byte that completes the text
  bool push(std::uint8_t byte) {
    if (text_.empty()) return false;
    const char c = static_cast<char>(byte);
    if (c != text_[matched_]) matched_ = 0;
    if (c == text_[matched_]) ++matched_;
    if (matched_ < text_.size()) return false;
    matched_ = 0;
    return true;
  }

 private:
  std::string_view text_;
  std::size_t matched_ = 0;
};

}  // namespace slam
