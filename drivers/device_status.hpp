// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>

#include "core/timestamp.hpp"
#include "problems/devices.hpp"

namespace slam {

enum class DeviceState : std::uint8_t { kAbsent, kOpening, kStreaming, kStale, kFault };

/// @param state also one from a message, that may be none
inline const char* nameOf(DeviceState state) {
  constexpr const char* kNames[] = {"ABSENT", "OPENING", "STREAMING", "STALE", "FAULT"};
  const auto i = static_cast<std::size_t>(state);
  return i < std::size(kNames) ? kNames[i] : "UNKNOWN";
}

/// What a driver's thread lets the supervisor see. Written by one thread, read by any; no lock.
struct DeviceStatus {
  std::atomic<DeviceState> state{DeviceState::kAbsent};
  std::atomic<std::int64_t> last_sample_ns{0};  ///< stamp of the last good sample, 0: none yet
  std::atomic<std::int64_t> samples{0};
  std::atomic<std::int64_t> rejects{0};
  std::atomic<std::int64_t> thinned{0};     ///< readings left out evenly, because there were too many to be used
  std::atomic<const char*> identity{""};    ///< what it says that it is; good until it was connected three times more
  std::atomic<std::int64_t> identified{0};  ///< how often that was set: once for each connection

  DeviceStatus() { problem_.store(problem::kNotOpened); }

  Problem problem() const { return problem_.load(); }
  void setProblem(const Problem& problem) { problem_.store(problem); }
  void set(DeviceState new_state, const Problem& why = {}) {
    problem_.store(why);
    state.store(new_state, std::memory_order_release);
  }
  /// It is being opened. What was wrong with one that failed stays to be read until it streams.
  /// @param doing said of any other
  void setOpening(const Problem& doing) {
    const DeviceState before = state;
    const bool failed = before == DeviceState::kStale || before == DeviceState::kFault;
    recovers_ = before == DeviceState::kOpening ? recovers_ : failed;
    recovers_ ? state.store(DeviceState::kOpening, std::memory_order_release) : set(DeviceState::kOpening, doing);
  }
  /// What the device says that it is, in words.
  void identify(std::string_view words) {
    auto& text = identities_[static_cast<std::size_t>(identified.load(std::memory_order_relaxed)) % identities_.size()];
    const std::size_t size = std::min(words.size(), text.size() - 1);
    std::copy_n(words.begin(), size, text.begin());
    text[size] = '\0';
    identity.store(text.data(), std::memory_order_release);
    identified.fetch_add(1, std::memory_order_release);
  }
  void countSample(Timestamp stamp) {
    last_sample_ns.store(stamp.time_since_epoch().count(), std::memory_order_relaxed);
    samples.fetch_add(1, std::memory_order_relaxed);
  }

 private:
  SharedProblem problem_;
  bool recovers_ = false;  // of the writing thread
  std::array<std::array<char, 256>, 4> identities_{};
};

}  // namespace slam
