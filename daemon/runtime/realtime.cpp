// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/realtime.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sstream>
#include <string_view>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace slam {
namespace {

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
  const bool fits = mapped <= limit && limit - mapped >= kRoomForStack;
  return {fits ? MemoryLock::kPresent : MemoryLock::kNothing,
          {fits ? problem::kNewMemoryNotLocked : problem::kMemoryNotLocked,
           {static_cast<double>(mapped >> 20), static_cast<double>(limit >> 20)}}};
}

void limitLibraryStacks() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kThreadStack);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

void shareOneHeap() { mallopt(M_ARENA_MAX, 1); }

Problem lockMemory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const bool privileged = limit.rlim_cur != RLIM_INFINITY && mayLockMoreThan(limit.rlim_cur);
  const MemoryLock lock = memoryLockFor(limit.rlim_cur, mappedBytes(), privileged);
  if (lock.extent == MemoryLock::kNothing) return lock.remark;
  // Of what comes later a page is taken when it is used, and stays: a library's stack is hardly used.
  const bool with_future = lock.extent == MemoryLock::kAll;
  if (mlockall(MCL_CURRENT) == 0 && (!with_future || mlockall(MCL_FUTURE | MCL_ONFAULT) == 0)) return lock.remark;
  return {problem::kMemoryRefused, {}, {std::strerror(errno)}};
}

Problem setFifoPriority(int priority) {
  const sched_param param{priority};
  // Threads that a library begins in a real-time thread are none.
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &param) == 0) return {};
  const int error = errno;
  return fifoProblem(error, priority, fifoRights());
}

FifoRights fifoRights(const std::filesystem::path& root, const std::string& id) {
  FifoRights rights;
  const std::filesystem::path process = root / "proc" / id;
  std::ifstream limits(process / "limits");
  for (std::string line; std::getline(limits, line);) {
    constexpr std::string_view kLimit = "Max realtime priority";
    if (!line.starts_with(kLimit)) continue;
    std::istringstream soft(line.substr(kLimit.size()));
    if (!(soft >> rights.limit)) rights.limit = std::numeric_limits<int>::max();  // unlimited
  }
  std::ifstream status(process / "status");
  for (std::string line; std::getline(status, line);) {
    constexpr unsigned long kSysNice = 1UL << 23;
    if (line.starts_with("CapEff:")) rights.privileged = (std::stoul(line.substr(7), nullptr, 16) & kSysNice) != 0;
    if (line.starts_with("Seccomp:")) rights.filtered = line.find_first_of("12") != std::string::npos;
  }
  // Of version 1 of control groups, whose controller has a folder of its own.
  std::ifstream groups(process / "cgroup");
  for (std::string line; std::getline(groups, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    std::istringstream controllers(line.substr(first + 1, second - first - 1));
    bool has_cpu = false;
    for (std::string controller; std::getline(controllers, controller, ',');) has_cpu |= controller == "cpu";
    if (!has_cpu) continue;
    for (const char* folder : {"cpu", "cpu,cpuacct"}) {
      const auto file = "/sys/fs/cgroup/" + std::string(folder) + line.substr(second + 1) + "/cpu.rt_runtime_us";
      std::ifstream in(root / file.substr(1));
      if (std::int64_t runtime = 0; in >> runtime) {
        rights.group_file = file;
        rights.group_runtime = runtime;
      }
    }
  }
  return rights;
}

Problem fifoProblem(int error, int priority, const FifoRights& rights) {
  if (error != EPERM) return {problem::kNoFifo, {}, {std::strerror(error)}};
  if (!rights.privileged && rights.limit < priority)
    return {problem::kNoFifoByLimit, {static_cast<double>(priority), static_cast<double>(rights.limit)}};
  if (rights.group_runtime == 0) return {problem::kNoFifoOfGroup, {}, {rights.group_file}};
  return rights.filtered ? problem::kNoFifoByFilter : problem::kNoFifoByKernel;
}

NormalPriority::NormalPriority(int priority) : priority_(priority) {
  const sched_param none{0};
  // The flag cannot be taken back without a capability.
  if (priority_ > 0) sched_setscheduler(0, SCHED_OTHER | SCHED_RESET_ON_FORK, &none);
}

NormalPriority::~NormalPriority() {
  const sched_param param{priority_};
  if (priority_ > 0) sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &param);
}

void nameThread(const std::string& name) { pthread_setname_np(pthread_self(), name.substr(0, 15).c_str()); }

}  // namespace slam
