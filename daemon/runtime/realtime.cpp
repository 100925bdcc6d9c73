// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/realtime.hpp"

#include <cerrno>
#include <cstring>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

namespace slam {

std::string lockMemory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return "";
  return std::string("memory is not locked: ") + std::strerror(errno) + "; set LimitMEMLOCK=infinity in the unit";
}

std::string setFifoPriority(int priority) {
  const sched_param param{priority};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);  // returns the error, leaves errno
  if (error == 0) return "";
  return std::string("no SCHED_FIFO: ") + std::strerror(error) + "; set LimitRTPRIO=95 in the unit";
}

void nameThread(const std::string& name) { pthread_setname_np(pthread_self(), name.substr(0, 15).c_str()); }

}  // namespace slam
