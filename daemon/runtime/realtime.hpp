// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>

namespace slam {

/// What may be locked, so that no page fault stops a real-time thread.
struct MemoryLock {
  enum Extent { kAll, kPresent, kNothing } extent = kAll;  ///< kAll: also what is mapped later
  std::string remark;                                      ///< what is not locked, and the fix; empty: nothing
};

/// Under a finite limit, future memory is not locked: mapping more than the limit would fail, and so would the process.
/// @param limit [bytes] RLIMIT_MEMLOCK; RLIM_INFINITY: none
/// @param mapped [bytes] of the process's address space, which all count
/// @param privileged the limit does not hold for this process
MemoryLock memoryLockFor(std::uint64_t limit, std::uint64_t mapped, bool privileged);

/// Locks the process's memory as far as its limit lets it. @return empty, or what is not locked and the fix
std::string lockMemory();

/// Gives the calling thread SCHED_FIFO. @return empty, or why not and how to fix it
std::string setFifoPriority(int priority);

/// Names the calling thread for ps and top (15 characters).
void nameThread(const std::string& name);

}  // namespace slam
