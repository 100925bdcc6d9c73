// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <sys/types.h>

namespace slam {

/// slamd.service, stopped for as long as this object lives: its ports are free meanwhile, and the wheels stand. It is
/// started again whatever happens to this program: a process of its own waits for its end.
class PausedService {
 public:
  /// Whether the service runs here.
  static bool runs();

  /// Stops it. @throws std::runtime_error where it cannot be stopped
  PausedService();
  ~PausedService() { resume(); }
  PausedService(const PausedService&) = delete;
  PausedService& operator=(const PausedService&) = delete;

  /// Starts it. @return false: systemctl could not
  bool resume();

 private:
  int lives_ = -1;     // our end of a pipe, which closes with this program
  pid_t waiter_ = -1;  // who starts the service then
};

}  // namespace slam
