// SPDX-License-Identifier: BSD-3-Clause
// For LD_PRELOAD: a disk that the kernel has made read-only after errors. As long as the file READ_ONLY_DISK_FILE
// exists, no file can be made or written, but for what stdio writes.
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

bool isReadOnly() {
  static const char* const file = std::getenv("READ_ONLY_DISK_FILE");
  return file != nullptr && access(file, F_OK) == 0;
}

int openFile(const char* path, int flags, unsigned mode) {
  if ((flags & O_CREAT) != 0 && isReadOnly()) return errno = EROFS, -1;
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = (flags & O_CREAT) != 0 ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  return openFile(path, flags, mode);
}
int mkdir(const char* path, mode_t mode) noexcept {
  if (isReadOnly()) return errno = EROFS, -1;
  return static_cast<int>(syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}
ssize_t write(int descriptor, const void* bytes, size_t size) {
  struct stat status {};
  if (isReadOnly() && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) return errno = EROFS, -1;
  return syscall(SYS_write, descriptor, bytes, size);
}
}
