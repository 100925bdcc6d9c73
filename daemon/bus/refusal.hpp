// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "problems/devices.hpp"

namespace slam {

/// Why a message is no measurement.
enum class Refusal : std::uint8_t {
  kNone,
  kType,    ///< another type's fingerprint
  kSize,    ///< its lengths do not fit its size
  kStamp,   ///< no time
  kLimits,  ///< its own limits contradict each other
  kValues,  ///< a number cannot be what it says
  kAhead,   ///< its stamp is in the future
  kOld      ///< its stamp is long past
};
inline constexpr std::size_t kRefusals = 8;

/// As counters have it.
const char* nameOf(Refusal refusal);
/// What is wrong with such messages, whatever they measure.
const char* meaningOf(Refusal refusal);
Problem problemOf(Refusal refusal, std::string_view channel);

/// Messages of one channel of a log, of which some were refused.
class RefusedMessages {
 public:
  explicit RefusedMessages(std::string_view channel) : channel_(channel) {}
  void count(Refusal refusal) {
    ++counts_[static_cast<std::size_t>(refusal)];
    if (refusal != Refusal::kNone) last_ = refusal;
  }
  /// How many, and why the last one; empty: none was.
  std::string words() const;

 private:
  std::string channel_;
  std::array<std::uint64_t, kRefusals> counts_{};
  Refusal last_ = Refusal::kNone;
};

/// Notes which messages of one channel are refused, and names them while many are: one that was damaged on its way is
/// counted, and no news. One thread writes; the counts may be read by any.
class RefusalNote {
 public:
  void refused(Refusal refusal);
  void taken() {
    if (level_ > 0) --level_;
    if (level_ == 0) noted_ = Refusal::kNone;
  }
  /// kNone: at most one message in five is refused.
  Refusal noted() const { return noted_; }
  std::int64_t count(Refusal refusal) const { return counts_[static_cast<std::size_t>(refusal)]; }

 private:
  std::array<std::atomic<std::int64_t>, kRefusals> counts_{};
  int level_ = 0;  // of a bucket that one refused message fills by as much as kShare good ones empty it
  Refusal noted_ = Refusal::kNone;
};

}  // namespace slam
