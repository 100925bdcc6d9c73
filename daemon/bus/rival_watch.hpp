// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/timestamp.hpp"

namespace slam {

/// Notices that somebody else publishes on a channel that is to be ours alone, such as a second slamd. A group's
/// packets return to their sender's machine: what is heard and was not sent from here is another's.
class RivalWatch {
 public:
  void sent(std::span<const std::uint8_t> message) { own_[next_++ % own_.size()] = digestOf(message); }
  void received(std::span<const std::uint8_t> message, Timestamp now) {
    if (std::find(own_.begin(), own_.end(), digestOf(message)) != own_.end()) return;
    before_ = last_;
    last_ = now;
  }
  /// Twice within two seconds: a single message may be a copy that came late. Over three seconds after the last.
  bool hasRival(Timestamp now) {
    const bool twice = before_ != Timestamp{} && last_ - before_ <= kTogether;
    has_ = last_ != Timestamp{} && now - last_ <= kOver && (has_ || twice);
    return has_;
  }

 private:
  static constexpr Duration kTogether = std::chrono::seconds(2), kOver = std::chrono::seconds(3);

  static std::size_t digestOf(std::span<const std::uint8_t> message) {
    return std::hash<std::string_view>{}({reinterpret_cast<const char*>(message.data()), message.size()});
  }

  std::array<std::size_t, 1024> own_{};  // digests of the last messages: of ten seconds at 100 Hz
  std::size_t next_ = 0;
  Timestamp before_{}, last_{};  // of the last two foreign messages
  bool has_ = false;
};

}  // namespace slam
