// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>

namespace slam::test {

/// While true, fsync() and fdatasync() of this program wait, as on a disk that does not answer. For programs that are
/// linked with slow_disk.cpp.
extern std::atomic<bool> disk_hangs;

/// As long as it lives, the disk hangs.
class HangingDisk {
 public:
  HangingDisk() { disk_hangs = true; }
  ~HangingDisk() { release(); }
  HangingDisk(const HangingDisk&) = delete;
  HangingDisk& operator=(const HangingDisk&) = delete;
  void release() {
    disk_hangs = false;
    disk_hangs.notify_all();
  }
};

}  // namespace slam::test
