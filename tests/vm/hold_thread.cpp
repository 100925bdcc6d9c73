// SPDX-License-Identifier: BSD-3-Clause
// Stops one thread of a program until that program is gone, as a fault in it would: hold_thread TID
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sys/ptrace.h>
#include <sys/wait.h>

int main(int argc, char** argv) {
  const int thread = argc == 2 ? std::atoi(argv[1]) : 0;
  if (ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0 || ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0) {
    std::fprintf(stderr, "hold_thread: %s: %s\n", argc == 2 ? argv[1] : "give a thread", std::strerror(errno));
    return 1;
  }
  int status = 0;
  if (waitpid(thread, &status, __WALL) != thread || !WIFSTOPPED(status)) return 1;
  std::puts("held");
  std::fflush(stdout);
  while (waitpid(thread, &status, __WALL) == thread && WIFSTOPPED(status)) {
  }
  return 0;
}
