// SPDX-License-Identifier: BSD-3-Clause
// For LD_PRELOAD: a wall clock that somebody sets. CLOCK_REALTIME is off by the seconds that the file CLOCK_OFFSET_FILE
// holds as a std::int64_t, which a test maps and changes.
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

const std::atomic<std::int64_t>* offset = nullptr;  // [s]

__attribute__((constructor)) void begin() {
  const char* const file = std::getenv("CLOCK_OFFSET_FILE");
  if (file == nullptr) return;
  const int descriptor = open(file, O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  void* const memory = mmap(nullptr, sizeof *offset, PROT_READ, MAP_SHARED | MAP_POPULATE, descriptor, 0);
  close(descriptor);
  if (memory != MAP_FAILED) offset = static_cast<const std::atomic<std::int64_t>*>(memory);
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const int result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (result == 0 && clock == CLOCK_REALTIME && offset != nullptr) time->tv_sec += *offset;
  return result;
}
