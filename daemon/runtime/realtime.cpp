// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/realtime.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace slam {
namespace {

const char* const kFix = "; set LimitMEMLOCK=infinity in the unit, or ulimit -l unlimited in a shell";
// [bytes] The main thread's stack is locked with the rest and counts as it grows: beyond the limit that is a SIGSEGV.
constexpr std::uint64_t kRoomForStack = 8 << 20;

std::uint64_t mappedBytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  statm >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// Asks the kernel, by locking that much address space without memory behind it. The capability alone says too little:
/// root of a user namespace has it, and the limit holds all the same.
bool mayLockMoreThan(std::uint64_t limit) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t size = static_cast<std::size_t>(limit) / page * page + page;
  void* const region = mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (region == MAP_FAILED) return false;
  const bool locked = mlock2(region, size, MLOCK_ONFAULT) == 0;
  munmap(region, size);
  return locked;
}

}  // namespace

MemoryLock memoryLockFor(std::uint64_t limit, std::uint64_t mapped, bool privileged) {
  if (limit == RLIM_INFINITY || privileged) return {};
  const std::string may =
      std::to_string(limit >> 20) + " MiB may be locked; the real-time threads may wait for memory" + kFix;
  if (mapped <= limit && limit - mapped >= kRoomForStack) {
    return {MemoryLock::kPresent, "memory that slamd takes from now on is not locked: only " + may};
  }
  return {MemoryLock::kNothing,
          "memory is not locked: " + std::to_string(mapped >> 20) + " MiB are in use and only " + may};
}

std::string lockMemory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const bool privileged = limit.rlim_cur != RLIM_INFINITY && mayLockMoreThan(limit.rlim_cur);
  const MemoryLock lock = memoryLockFor(limit.rlim_cur, mappedBytes(), privileged);
  if (lock.extent == MemoryLock::kNothing) return lock.remark;
  const int what = lock.extent == MemoryLock::kAll ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT;
  if (mlockall(what) == 0) return lock.remark;
  return std::string("memory is not locked: ") + std::strerror(errno) + kFix;
}

std::string setFifoPriority(int priority) {
  const sched_param param{priority};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);  // returns the error, leaves errno
  if (error == 0) return "";
  return std::string("no SCHED_FIFO: ") + std::strerror(error) + "; set LimitRTPRIO=95 in the unit";
}

void nameThread(const std::string& name) { pthread_setname_np(pthread_self(), name.substr(0, 15).c_str()); }

}  // namespace slam
