// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/realtime.hpp"

#include <barrier>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "tools/files.hpp"

namespace slam::realtime_test {
namespace {

using testing::HasSubstr;
constexpr std::uint64_t kMiB = 1 << 20;
constexpr int kNotAllowed = 77;  // to have such a limit

TEST(MemoryLock, LocksTheFutureOnlyWhereNoLimitHolds) {
  EXPECT_EQ(memoryLockFor(RLIM_INFINITY, 500 * kMiB, false).extent, MemoryLock::kAll);
  EXPECT_EQ(memoryLockFor(RLIM_INFINITY, 500 * kMiB, false).remark, Problem());
  EXPECT_EQ(memoryLockFor(8 * kMiB, 500 * kMiB, true).extent, MemoryLock::kAll);
  for (const std::uint64_t limit : {0UL, 64 * kMiB, 96 * kMiB, 128 * kMiB, 512 * kMiB, 64 * 1024 * kMiB}) {
    EXPECT_NE(memoryLockFor(limit, 100 * kMiB, false).extent, MemoryLock::kAll) << limit;
    EXPECT_THAT(memoryLockFor(limit, 100 * kMiB, false).remark.words(), HasSubstr("LimitMEMLOCK=infinity")) << limit;
  }
}

TEST(MemoryLock, LocksWhatIsMappedWhereTheStackMayStillGrow) {
  EXPECT_EQ(memoryLockFor(512 * kMiB, 100 * kMiB, false).extent, MemoryLock::kPresent);
  EXPECT_THAT(memoryLockFor(512 * kMiB, 100 * kMiB, false).remark.words(),
              HasSubstr("from now on is not locked: only 512 MiB"));
  EXPECT_EQ(memoryLockFor(104 * kMiB, 100 * kMiB, false).extent, MemoryLock::kNothing) << "its growth is locked, too";
  EXPECT_EQ(memoryLockFor(64 * kMiB, 100 * kMiB, false).extent, MemoryLock::kNothing);
  EXPECT_THAT(memoryLockFor(64 * kMiB, 100 * kMiB, false).remark.words(),
              HasSubstr("memory is not locked: 100 MiB are in use and only 64 MiB"));
}

/// Takes the right to lock without limit from this process.
void giveUpIpcLock() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[2] = {};
  if (syscall(SYS_capget, &header, data) != 0) _exit(10);
  for (auto* set : {&data[0].effective, &data[0].permitted}) *set &= ~(1U << CAP_IPC_LOCK);
  if (syscall(SYS_capset, &header, data) != 0) _exit(11);
}

/// In a process of its own: a program under such a limit can take memory behind lockMemory(), and its stack can grow.
int exitCodeUnder(rlim_t limit) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit bound{limit, limit};
    if (setrlimit(RLIMIT_MEMLOCK, &bound) != 0) _exit(kNotAllowed);
    giveUpIpcLock();
    if (!lockMemory()) _exit(13);
    for (int i = 0; i < 40; ++i) {
      if (mmap(nullptr, 16 * kMiB, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED) _exit(14);
    }
    volatile char deep[4 * kMiB];
    for (std::size_t i = 0; i < sizeof deep; i += 4096) deep[i] = 1;
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(MemoryLock, LeavesRoomForAllThatComesLater) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizers' shadow memory cannot be locked";
#endif
  for (const rlim_t limit : {rlim_t{0}, 4 * kMiB, 8 * kMiB, 16 * kMiB, 64 * kMiB, 128 * kMiB, 512 * kMiB}) {
    const int code = exitCodeUnder(limit);
    if (code != kNotAllowed) {
      EXPECT_EQ(code, 0) << limit / kMiB << " MiB";
    }
  }
}

TEST(LibraryStacks, AreAsLargeAsThoseOfSlamd) {
  pthread_attr_t before;
  ASSERT_EQ(pthread_getattr_default_np(&before), 0);
  limitLibraryStacks();
  std::size_t size = 0;
  std::thread([&] {
    pthread_attr_t own;
    pthread_getattr_np(pthread_self(), &own);
    pthread_attr_getstacksize(&own, &size);
    pthread_attr_destroy(&own);
  }).join();
  EXPECT_EQ(size, kThreadStack);
  pthread_setattr_default_np(&before);
  pthread_attr_destroy(&before);
}

int policyOfThisThread() { return sched_getscheduler(0) & ~SCHED_RESET_ON_FORK; }

TEST(FifoPriority, IsNotInheritedByThreadsThatALibraryBegins) {
  int own = -1, begun = -1, connecting = -1, back = -1;
  Problem problem;
  std::thread([&] {
    problem = setFifoPriority(1);
    own = policyOfThisThread();
    std::thread([&] { begun = policyOfThisThread(); }).join();
    {
      const NormalPriority normal(1);
      connecting = policyOfThisThread();
    }
    back = policyOfThisThread();
  }).join();
  if (problem) GTEST_SKIP() << problem.words();
  EXPECT_EQ(own, SCHED_FIFO);
  EXPECT_EQ(begun, SCHED_OTHER);
  EXPECT_EQ(connecting, SCHED_OTHER);
  EXPECT_EQ(back, SCHED_FIFO);
}

TEST(FifoProblem, NamesTheTrueCauseOfARefusal) {
  EXPECT_THAT(fifoProblem(EPERM, 80, {.limit = 0}).words(), HasSubstr("LimitRTPRIO=95"));
  EXPECT_THAT(fifoProblem(EPERM, 80, {.limit = 50}).words(), HasSubstr("priority 80 where the limit is 50"));
  const std::string group =
      fifoProblem(EPERM, 80, {.limit = 95, .group_file = "/sys/fs/cgroup/cpu/x/cpu.rt_runtime_us", .group_runtime = 0})
          .words();
  EXPECT_THAT(group, HasSubstr("cpu.rt_runtime_us is 0"));
  EXPECT_THAT(group, HasSubstr("tee /sys/fs/cgroup/cpu/x/cpu.rt_runtime_us"));
  EXPECT_THAT(group, testing::Not(HasSubstr("LimitRTPRIO")));
  const std::string unseen = fifoProblem(EPERM, 80, {.limit = 95, .filtered = true}).words();
  EXPECT_THAT(unseen, HasSubstr("CONFIG_RT_GROUP_SCHED"));
  EXPECT_THAT(unseen, HasSubstr("RestrictRealtime"));
  EXPECT_THAT(unseen, testing::Not(HasSubstr("LimitRTPRIO")));
  EXPECT_THAT(fifoProblem(EPERM, 80, {.limit = 0, .privileged = true}).words(), testing::Not(HasSubstr("LimitRTPRIO")));
  EXPECT_THAT(fifoProblem(EINVAL, 800, {}).words(), HasSubstr("Invalid argument"));
}

TEST(FifoRights, AreReadOfStatusAndControlGroup) {
  const test::Folder root;
  for (const char* folder : {"proc/self", "sys/fs/cgroup/cpu/system.slice/slamd.service"})
    std::filesystem::create_directories(root / folder);
  root.write("proc/self/status", "Name:\tslamd\nCapEff:\t0000000000800000\nSeccomp:\t2\n");
  root.write("proc/self/cgroup", "3:cpuset:/\n2:cpu,cpuacct:/system.slice/slamd.service\n0::/x\n");
  root.write("sys/fs/cgroup/cpu/system.slice/slamd.service/cpu.rt_runtime_us", "0\n");
  root.write("proc/self/limits",
             "Limit                     Soft Limit           Hard Limit           Units     \n"
             "Max realtime priority     42                   95                   \n");
  const FifoRights rights = fifoRights(root / "");
  EXPECT_EQ(rights.limit, 42);
  EXPECT_EQ(fifoRights(root / "", "1234").limit, 0) << "there is no such process";
  EXPECT_TRUE(rights.privileged);
  EXPECT_TRUE(rights.filtered);
  EXPECT_EQ(rights.group_runtime, 0);
  EXPECT_EQ(rights.group_file, "/sys/fs/cgroup/cpu/system.slice/slamd.service/cpu.rt_runtime_us");
}

/// Of this process, as glibc counts them.
int heaps() {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const file = open_memstream(&text, &size);
  malloc_info(0, file);
  std::fclose(file);
  int count = 0;
  for (const char* at = text; (at = std::strstr(at, "<heap nr=")) != nullptr; ++at) ++count;
  std::free(text);
  return count;
}

TEST(Heap, IsOneForAllThreads) {
  shareOneHeap();
  const int before = heaps();
  std::vector<std::thread> threads;
  std::barrier together(4);  // one that ends leaves its heap to the next
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      const std::vector<char> allocated(1000);
      together.arrive_and_wait();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(heaps(), before);
}

}  // namespace
}  // namespace slam::realtime_test
