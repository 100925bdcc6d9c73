// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace slam {

/// Finds frames in a stream of bytes. After damage it looks for the next one inside the bytes that it holds, so that a
/// good frame right behind a damaged one is not lost.
/// @tparam Format has kLongest [bytes]; sizeOf(bytes), the size of the frame that begins there, 0 where none does,
/// nullopt while that is not known; isGood(frame), whether its checksum is right
template <typename Format>
class FrameDecoder {
 public:
  using Bytes = std::span<const std::uint8_t>;

  /// Takes one byte. @param take gets each frame that it completes, or that was held back by damage; the frame lives
  /// until take() returns
  template <typename Take>
  void push(std::uint8_t byte, Take&& take) {
    buffer_[size_++] = byte;
    while (size_ > 0) {
      const Bytes held(buffer_.data(), size_);
      const std::optional<std::size_t> size = Format::sizeOf(held);
      if (!size && size_ < Format::kLongest) return;
      if (!size || *size == 0 || *size > Format::kLongest) {
        ++skipped_;
        drop(1);
      } else if (size_ < *size) {
        return;
      } else if (!Format::isGood(held.first(*size))) {
        ++damaged_;
        drop(1);
      } else {
        take(held.first(*size));
        drop(*size);
      }
    }
  }
  void reset() { size_ = 0; }

  std::uint32_t damaged() const { return damaged_; }  ///< frames with a wrong checksum
  std::uint32_t skipped() const { return skipped_; }  ///< bytes outside of frames

 private:
  void drop(std::size_t count) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
              buffer_.begin() + static_cast<std::ptrdiff_t>(size_), buffer_.begin());
    size_ -= count;
  }

  std::array<std::uint8_t, Format::kLongest> buffer_{};
  std::size_t size_ = 0;
  std::uint32_t damaged_ = 0, skipped_ = 0;
};

}  // namespace slam
