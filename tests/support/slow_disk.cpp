// SPDX-License-Identifier: BSD-3-Clause
// The C library's fsync(), fdatasync() and flock() as of a disk that may hang: linked into a test they take the place
// of the real ones. As a library for LD_PRELOAD (SLOW_DISK_FILE) the disk hangs as long as the file of that name
// exists.
#include <atomic>
#include <cstdlib>
#include <sys/syscall.h>
#include <unistd.h>

namespace slam::test {
std::atomic<bool> disk_hangs{false};
}  // namespace slam::test

namespace {

void wait() {
  slam::test::disk_hangs.wait(true);
  const char* const file = std::getenv("SLOW_DISK_FILE");
  while (file != nullptr && access(file, F_OK) == 0) usleep(10000);
}

}  // namespace

extern "C" int fsync(int descriptor) {
  wait();
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

extern "C" int fdatasync(int descriptor) {
  wait();
  return static_cast<int>(syscall(SYS_fdatasync, descriptor));
}

extern "C" int flock(int descriptor, int operation) {
  wait();
  return static_cast<int>(syscall(SYS_flock, descriptor, operation));
}
