// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <sys/types.h>

#include "core/timestamp.hpp"

namespace slam {

/// What a thread has had of the CPU since it began, as the kernel counts. What is neither is time in which it slept, or
/// a disk, a device or a lock kept it.
struct ThreadUse {
  Duration ran{0};
  Duration waited{0};     ///< for the CPU, while others had it
  bool is_ready = false;  ///< it runs or waits for the CPU now; such a wait is counted only when it ends
};
/// @param id of a thread of this process, as gettid() has it @param root of /proc
/// @return std::nullopt: there is no such thread
std::optional<ThreadUse> threadUse(pid_t id, const std::filesystem::path& root = "/");

/// The part of the time between two looks at a thread in which it waited for the CPU.
/// @param step between the looks
Duration starvedBetween(const ThreadUse& before, const ThreadUse& now, Duration step);

/// How long a thread is kept from a piece of work by anything but the CPU, such as a disk. One thread works, any may
/// look.
class BlockedTime {
 public:
  /// The calling thread begins.
  void begin(Timestamp now);
  void end() { since_ns_ = 0; }
  /// Time of the work so far in which the thread neither ran nor waited for the CPU; 0 where it does so now, or does
  /// not work.
  Duration until(Timestamp now) const;

 private:
  std::atomic<pid_t> thread_{0};
  std::atomic<std::int64_t> since_ns_{0};  // begin of the work; 0: none
  std::atomic<std::int64_t> used_ns_{0};   // that the thread had run and waited for the CPU by then
};

}  // namespace slam
