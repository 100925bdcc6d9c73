// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <random>
#include <vector>

namespace slam::test {

/// What a virtual machine wrote to its disk, in order, with its flushes: a log of QEMU's driver blklogwrites (the
/// format of Linux's dm-log-writes).
class WriteLog {
 public:
  struct Entry {
    std::uint64_t sector = 0, sectors = 0;  ///< of sectorSize() bytes; 0 sectors: a flush or a mark
    std::uint64_t flags = 0;
    std::uint64_t data = 0;  ///< [bytes] where its data begin in the log's file
    bool flush() const { return (flags & 1U) != 0; }
    bool through() const { return (flags & 2U) != 0; }  ///< it was on the disk when it was acknowledged
    bool discard() const { return (flags & 4U) != 0; }
  };

  /// Reads a log that may end anywhere. @throws std::runtime_error where it is none
  explicit WriteLog(const std::filesystem::path& file);

  const std::vector<Entry>& entries() const { return entries_; }
  std::uint64_t sectorSize() const { return sector_size_; }

  /// What a power cut has left of the writes.
  struct Cut {
    int durable = 0;    ///< writes that a flush had made durable
    int unflushed = 0;  ///< the rest ...
    int kept = 0;       ///< ... of which so many reached the disk whole,
    int torn = 0;       ///< so many in part
  };
  /// Does to a disk as it was before the log what a power cut behind `count` entries does: all before the last flush is
  /// there; of each physical block of 4 KiB behind it nobody knows, and a disk writes them in any order.
  /// @throws std::runtime_error where the image cannot be written
  Cut apply(const std::filesystem::path& image, std::size_t count, std::mt19937_64& random) const;

 private:
  std::filesystem::path file_;
  std::uint64_t sector_size_ = 512;
  std::vector<Entry> entries_;
};

}  // namespace slam::test
