// SPDX-License-Identifier: BSD-3-Clause
// For LD_PRELOAD: counts what each thread of real-time scheduling does that may make it wait, in a file that a test
// maps (THREAD_WORK_FILE). Allocations, opened files, and mutexes that another thread held.
#include "support/thread_work.hpp"

#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);
}

namespace {

using slam::test::ThreadWork;
using slam::test::WorkTable;

int (*lock)(pthread_mutex_t*) = nullptr;  // of the C library
WorkTable* table = nullptr;
[[gnu::tls_model("initial-exec")]] thread_local ThreadWork* own = nullptr;

__attribute__((constructor)) void begin() {
  lock = reinterpret_cast<int (*)(pthread_mutex_t*)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  const char* const file = std::getenv("THREAD_WORK_FILE");
  if (file == nullptr) return;
  const int descriptor = static_cast<int>(syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC, 0));
  if (descriptor < 0) return;
  void* const memory =
      mmap(nullptr, sizeof(WorkTable), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, descriptor, 0);
  close(descriptor);
  if (memory != MAP_FAILED) table = static_cast<WorkTable*>(memory);
}

/// @return nullptr for a thread that may wait
ThreadWork* workOfRealTime() {
  if (table == nullptr) return nullptr;
  const int policy = static_cast<int>(syscall(SYS_sched_getscheduler, 0));
  if ((policy & ~SCHED_RESET_ON_FORK) != SCHED_FIFO) return nullptr;
  if (own == nullptr) {
    const std::size_t index = table->used.fetch_add(1);
    if (index >= table->threads.size()) return nullptr;
    own = &table->threads[index];
    own->thread = static_cast<std::int32_t>(syscall(SYS_gettid));
  }
  return own;
}

template <typename Counter>
void count(Counter ThreadWork::*counter) {
  if (ThreadWork* const work = workOfRealTime()) ++(work->*counter);
}

int openAt(int folder, const char* path, int flags, unsigned mode) {
  count(&ThreadWork::opens);
  return static_cast<int>(syscall(SYS_openat, folder, path, flags, mode));
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) {
  count(&ThreadWork::allocations);
  return __libc_malloc(size);
}
void* calloc(std::size_t count_of, std::size_t size) {
  count(&ThreadWork::allocations);
  return __libc_calloc(count_of, size);
}
void* realloc(void* memory, std::size_t size) {
  count(&ThreadWork::allocations);
  return __libc_realloc(memory, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count(&ThreadWork::allocations);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  *memory = memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) {
  if (memory != nullptr) count(&ThreadWork::frees);
  __libc_free(memory);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  int taken = pthread_mutex_trylock(mutex);
  if (taken != EBUSY) return taken;
  count(&ThreadWork::waits);
  if (lock != nullptr) return lock(mutex);
  while ((taken = pthread_mutex_trylock(mutex)) == EBUSY) sched_yield();  // before begin()
  return taken;
}

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = (flags & O_CREAT) != 0 ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  return openAt(AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = (flags & O_CREAT) != 0 ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  return openAt(AT_FDCWD, path, flags, mode);
}
}
