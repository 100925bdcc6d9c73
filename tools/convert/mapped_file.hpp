// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace slam {

/// The bytes of a file, read by the kernel as they are looked at. The file must not shrink meanwhile.
class MappedFile {
 public:
  /// @throws std::runtime_error when it cannot be opened
  explicit MappedFile(const std::filesystem::path& file) {
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    const bool good = descriptor >= 0 && ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    void* begin = nullptr;
    if (good && status.st_size > 0) {
      begin = ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_PRIVATE, descriptor, 0);
    }
    const int error = errno;
    if (descriptor >= 0) ::close(descriptor);
    if (!good || begin == MAP_FAILED) {
      throw std::runtime_error(file.string() +
                               ": cannot open: " + (descriptor >= 0 && !good ? "not a file" : std::strerror(error)));
    }
    if (begin != nullptr) {
      bytes_ = {static_cast<const std::uint8_t*>(begin), static_cast<std::size_t>(status.st_size)};
    }
  }
  ~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::uint8_t*>(bytes_.data()), bytes_.size());
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace slam
