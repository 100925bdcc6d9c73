// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bus/udpm/lc02.hpp"

namespace slam {

/// Puts messages together that came in several packets, and believes no length in them: a message takes memory as its
/// parts come, and kLargest at most; of unfinished ones the oldest gives way.
class FragmentAssembler {
 public:
  static constexpr std::size_t kLargest = 1 << 21;  ///< [bytes] twice a scan of as many beams as are decoded
  static constexpr std::size_t kUnfinished = 4;

  struct Whole {
    std::string_view channel;
    std::span<const std::uint8_t> data;
  };

  /// @param wanted whether somebody subscribed to a channel: others' messages are not kept
  /// @return the message that this part completes, good until the next call
  std::optional<Whole> take(const Fragment& fragment, const std::function<bool(std::string_view)>& wanted);

 private:
  struct Unfinished {
    std::uint32_t sequence = 0, size = 0;
    std::uint16_t parts = 0, next = 0;  // of them, and the one that is due
    std::string channel;
    std::vector<std::uint8_t> data;
  };

  std::array<Unfinished, kUnfinished> unfinished_;
  std::size_t oldest_ = 0;
};

}  // namespace slam
