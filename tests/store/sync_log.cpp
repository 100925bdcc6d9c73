// SPDX-License-Identifier: BSD-3-Clause
#include "store/sync_log.hpp"

#include <array>
#include <sys/syscall.h>
#include <unistd.h>

namespace slam::test {

std::vector<std::string>& syncLog() {
  static std::vector<std::string> log;
  return log;
}

namespace {

int syncNoted(long call, int descriptor) {
  std::array<char, 4096> name{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  if (::readlink(link.c_str(), name.data(), name.size() - 1) > 0) syncLog().emplace_back(name.data());
  return static_cast<int>(::syscall(call, descriptor));
}

}  // namespace
}  // namespace slam::test

extern "C" int fsync(int descriptor) { return slam::test::syncNoted(SYS_fsync, descriptor); }
extern "C" int fdatasync(int descriptor) { return slam::test::syncNoted(SYS_fdatasync, descriptor); }
