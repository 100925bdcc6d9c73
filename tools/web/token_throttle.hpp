// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <chrono>
#include <map>
#include <string>

#include "core/timestamp.hpp"

namespace slam {

/// Slows down who guesses a token: after a few wrong ones an address has to wait before the next one is looked at, and
/// each time twice as long. Others are not held up. Time is data; one thread at a time.
class TokenThrottle {
 public:
  struct Limits {
    int free = 5;                                   ///< wrong ones, as of a typing error, before any wait
    Duration first = std::chrono::seconds(1);       ///< wait behind the next one; doubles ...
    Duration longest = std::chrono::minutes(1);     ///< ... up to this: 1,440 guesses a day
    Duration forgotten = std::chrono::minutes(10);  ///< an address without a wrong one for so long begins anew
    std::size_t most = 256;                         ///< addresses that are remembered; the longest quiet one goes first
  };

  explicit TokenThrottle(const Limits& limits) : limits_(limits) {}

  /// How long this address has to wait until a token of its is looked at; 0: not at all.
  Duration wait(const std::string& address, Timestamp now) const {
    const auto at = guessers_.find(address);
    return at == guessers_.end() ? Duration(0) : std::max(at->second.next - now, Duration(0));
  }
  void wrong(const std::string& address, Timestamp now) {
    std::erase_if(guessers_, [&](const auto& guesser) { return now - guesser.second.last > limits_.forgotten; });
    if (guessers_.size() >= limits_.most && !guessers_.contains(address)) {
      guessers_.erase(std::min_element(guessers_.begin(), guessers_.end(),
                                       [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
    }
    Guesser& guesser = guessers_[address];
    guesser.last = guesser.next = now;
    if (++guesser.wrong <= limits_.free) return;
    guesser.wait = std::clamp(2 * guesser.wait, limits_.first, limits_.longest);
    guesser.next = now + guesser.wait;
  }
  void right(const std::string& address) { guessers_.erase(address); }

 private:
  struct Guesser {
    int wrong = 0;
    Duration wait{0};
    Timestamp last{}, next{};
  };
  const Limits limits_;
  std::map<std::string, Guesser> guessers_;
};

}  // namespace slam
