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

  /// What lies before is not looked at again soon, and needs no memory meanwhile. @param rest the bytes behind it
  void release(std::span<const std::uint8_t> rest) {
    constexpr std::size_t kStep = std::size_t{4} << 20;  // [bytes] at once; a multiple of a page
    const std::size_t until = (bytes_.size() - rest.size()) / kStep * kStep;
    if (until <= released_) return;
    ::madvise(const_cast<std::uint8_t*>(bytes_.data() + released_), until - released_, MADV_DONTNEED);
    released_ = until;
  }

 private:
  std::size_t released_ = 0;
  std::span<const std::uint8_t> bytes_;
};

}  // namespace slam
