// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fcntl.h>
#include <filesystem>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace slam::test {

/// A file that cannot be removed as long as this lives, by root neither.
class Irremovable {
 public:
  explicit Irremovable(const std::filesystem::path& file) : folder_(file.parent_path()) {
    descriptor_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (::geteuid() == 0) {
      holds_ = setImmutable(true);
    } else {
      std::filesystem::permissions(folder_, std::filesystem::perms(0555));
      holds_ = true;
    }
  }
  ~Irremovable() {
    if (::geteuid() == 0) {
      setImmutable(false);
    } else {
      std::filesystem::permissions(folder_, std::filesystem::perms(0755));
    }
    ::close(descriptor_);
  }
  Irremovable(const Irremovable&) = delete;
  Irremovable& operator=(const Irremovable&) = delete;

  /// @return false where root's file system knows no such flag
  bool holds() const { return holds_; }

 private:
  bool setImmutable(bool immutable) const {
    int flags = 0;
    if (::ioctl(descriptor_, FS_IOC_GETFLAGS, &flags) != 0) return false;
    flags = immutable ? flags | FS_IMMUTABLE_FL : flags & ~FS_IMMUTABLE_FL;
    return ::ioctl(descriptor_, FS_IOC_SETFLAGS, &flags) == 0;
  }

  std::filesystem::path folder_;
  int descriptor_ = -1;
  bool holds_ = false;
};

}  // namespace slam::test
