// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "problems/daemon.hpp"

namespace slam {

/// What may be locked, so that no page fault stops a real-time thread.
struct MemoryLock {
  enum Extent { kAll, kPresent, kNothing } extent = kAll;  ///< kAll: also what is mapped later
  Problem remark = {};                                     ///< what is not locked
};

/// Under a finite limit, future memory is not locked: mapping more than the limit would fail, and so would the process.
/// @param limit [bytes] RLIMIT_MEMLOCK; RLIM_INFINITY: none
/// @param mapped [bytes] of the process's address space, which all count
/// @param privileged the limit does not hold for this process
MemoryLock memoryLockFor(std::uint64_t limit, std::uint64_t mapped, bool privileged);

constexpr std::size_t kThreadStack = 1 << 20;  ///< [bytes] of slamd's threads

/// Gives threads that a library begins from now on a stack of kThreadStack, instead of the 8 MiB that are usual: those
/// that exist when the memory is locked are locked whole.
void limitLibraryStacks();

/// Lets all threads allocate from one heap. glibc gives each thread that allocates a heap of its own, which keeps the
/// most that this thread ever had; real-time threads do not allocate, so that none waits for another one's lock.
void shareOneHeap();

/// Locks the process's memory as far as its limit lets it. @return what is not locked
Problem lockMemory();

/// Gives the calling thread SCHED_FIFO, but not the threads that it begins. @return why not
Problem setFifoPriority(int priority);

/// What the kernel asks for before it gives a thread SCHED_FIFO.
struct FifoRights {
  int limit = 0;                ///< RLIMIT_RTPRIO
  bool privileged = false;      ///< CAP_SYS_NICE, for which the limit does not hold
  bool filtered = false;        ///< system calls are
  std::string group_file = {};  ///< cpu.rt_runtime_us of this process's group, where it can be seen ...
  std::optional<std::int64_t> group_runtime = {};  ///< ... and its value [us]
};
/// @param root of /proc and /sys @param id of the process
FifoRights fifoRights(const std::filesystem::path& root = "/", const std::string& id = "self");
/// Why it was refused. @param error errno
Problem fifoProblem(int error, int priority, const FifoRights& rights);

/// The calling thread has normal priority while this lives: for what allocates and waits, such as opening a device.
class NormalPriority {
 public:
  /// @param priority of SCHED_FIFO, to come back to; 0: it has none
  explicit NormalPriority(int priority);
  ~NormalPriority();
  NormalPriority(const NormalPriority&) = delete;
  NormalPriority& operator=(const NormalPriority&) = delete;

 private:
  int priority_;
};

/// Names the calling thread for ps and top (15 characters).
void nameThread(const std::string& name);

}  // namespace slam
