// SPDX-License-Identifier: BSD-3-Clause
// The C library's ioctl() where each terminal has modem lines, so that a pseudo-terminal is to libserialport what a
// serial port is: linked into a test it takes the place of the real one. As a library for LD_PRELOAD the lines are
// there if MODEM_LINES is in the environment.
#include "support/modem_lines.hpp"

#include <cstdarg>
#include <cstdlib>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace slam::test {
std::atomic<bool> has_modem_lines{std::getenv("MODEM_LINES") != nullptr};
std::atomic<int> modem_lines{0};
}  // namespace slam::test

extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  const auto lines = [&] { return static_cast<int*>(argument); };
  if (slam::test::has_modem_lines) {
    if (request == TIOCMGET) return *lines() = slam::test::modem_lines, 0;
    if (request == TIOCMSET) return slam::test::modem_lines = *lines(), 0;
    if (request == TIOCMBIS) return slam::test::modem_lines |= *lines(), 0;
    if (request == TIOCMBIC) return slam::test::modem_lines &= ~*lines(), 0;
  }
  return static_cast<int>(syscall(SYS_ioctl, descriptor, request, argument));
}
