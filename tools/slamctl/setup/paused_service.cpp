// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/paused_service.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace slam {
namespace {

[[noreturn]] void becomeSystemctl(const char* verb) {
  execlp("systemctl", "systemctl", "--quiet", verb, "slamd.service", static_cast<char*>(nullptr));
  _exit(127);
}

int exitCodeOf(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int systemctl(const char* verb) {
  const pid_t process = fork();
  if (process == 0) becomeSystemctl(verb);
  return process < 0 ? -1 : exitCodeOf(process);
}

}  // namespace

bool PausedService::runs() { return systemctl("is-active") == 0; }

PausedService::PausedService() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("slamd.service: no pipe can be made");
  lives_ = ends[1];
  waiter_ = fork();
  if (waiter_ == 0) {
    setsid();  // Ctrl-C is for the other one
    close(ends[1]);
    char nothing = 0;
    while (read(ends[0], &nothing, 1) < 0 && errno == EINTR) {
    }
    becomeSystemctl("start");
  }
  close(ends[0]);
  if (waiter_ < 0) {
    close(lives_);
    throw std::runtime_error("slamd.service: no process can be made that would start it again");
  }
  if (systemctl("stop") == 0) return;
  resume();  // it may have been half-way
  throw std::runtime_error("slamd.service cannot be stopped: run sudo slamctl setup");
}

bool PausedService::resume() {
  if (lives_ >= 0) close(std::exchange(lives_, -1));
  return waiter_ < 0 || exitCodeOf(std::exchange(waiter_, -1)) == 0;
}

}  // namespace slam
