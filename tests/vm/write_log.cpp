// SPDX-License-Identifier: BSD-3-Clause
#include "vm/write_log.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fcntl.h>
#include <stdexcept>
#include <string>
#include <unistd.h>

namespace slam::test {
namespace {

constexpr std::uint64_t kMagic = 0x6a736677736872, kVersion = 1;
/// [bytes] What a disk writes whole or not at all. SD cards, eMMC, SSDs and today's hard disks write pages of this size
/// or larger. ext4 rests on it: a journal's commit block of which half is there has a wrong checksum, and the kernel
/// refuses the file system ("journal transaction is corrupt").
constexpr std::uint64_t kPhysicalBlock = 4096;

/// A file that is closed with the block.
class File {
 public:
  File(const std::filesystem::path& path, int flags) : path_(path), descriptor_(open(path.c_str(), flags | O_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error(path.string() + ": " + std::strerror(errno));
  }
  ~File() { close(descriptor_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  /// @return false at the end
  bool read(void* bytes, std::size_t size, std::uint64_t at) const {
    return pread(descriptor_, bytes, size, static_cast<off_t>(at)) == static_cast<ssize_t>(size);
  }
  void write(const void* bytes, std::size_t size, std::uint64_t at) const {
    if (pwrite(descriptor_, bytes, size, static_cast<off_t>(at)) == static_cast<ssize_t>(size)) return;
    throw std::runtime_error(path_.string() + ": " + std::strerror(errno));
  }

 private:
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace

WriteLog::WriteLog(const std::filesystem::path& file) : file_(file) {
  const std::uint64_t end = std::filesystem::file_size(file);
  if (end == 0) return;  // nothing was written
  const File log(file, O_RDONLY);
  struct {
    std::uint64_t magic = 0, version = 0, entries = 0;
    std::uint32_t sector_size = 0;
  } super;
  if (!log.read(&super, 28, 0) || super.magic != kMagic || super.version != kVersion || super.sector_size < 512 ||
      super.sector_size > 65536) {
    throw std::runtime_error(file.string() + ": is no log of blklogwrites");
  }
  sector_size_ = super.sector_size;
  for (std::uint64_t at = sector_size_; entries_.size() < super.entries;) {
    std::array<std::uint64_t, 4> raw{};  // sector, sectors, flags, length of a mark
    if (!log.read(raw.data(), sizeof raw, at)) break;
    const Entry entry{.sector = raw[0], .sectors = raw[1], .flags = raw[2], .data = at + sector_size_};
    const std::uint64_t size = entry.discard() ? 0 : entry.sectors;
    if (size > (end - at) / sector_size_) break;
    at += (1 + size) * sector_size_;
    if (at > end) break;
    entries_.push_back(entry);
  }
}

WriteLog::Cut WriteLog::apply(const std::filesystem::path& image, std::size_t count, std::mt19937_64& random) const {
  count = std::min(count, entries_.size());
  std::size_t flushed = 0;  // entries before the last flush
  for (std::size_t i = 0; i < count; ++i) {
    if (entries_[i].flush()) flushed = i;
  }
  const File log(file_, O_RDONLY), disk(image, O_WRONLY);
  // How much of it reached the disk is a matter of when it was cut: nothing, all, or anything between.
  const double share = std::uniform_real_distribution(-0.2, 1.2)(random);
  const auto happens = [&](double probability) {
    return std::uniform_real_distribution(0.0, 1.0)(random) < probability;
  };
  Cut cut;
  std::vector<char> bytes;
  for (std::size_t i = 0; i < count; ++i) {
    const Entry& entry = entries_[i];
    if (entry.sectors == 0 || entry.discard()) continue;  // what is discarded may as well stay
    const bool durable = i < flushed || entry.through();
    bytes.resize(entry.sectors * sector_size_);
    if (!log.read(bytes.data(), bytes.size(), entry.data))
      throw std::runtime_error(file_.string() + ": ends too early");
    const std::uint64_t begin = entry.sector * sector_size_;
    durable ? ++cut.durable : ++cut.unflushed;
    if (durable || happens(share)) {
      disk.write(bytes.data(), bytes.size(), begin);
      if (!durable) ++cut.kept;
    } else if (happens(0.3)) {
      ++cut.torn;
      for (std::uint64_t at = 0, end = 0; at < bytes.size(); at = end) {
        end = std::min<std::uint64_t>(bytes.size(), at + kPhysicalBlock - (begin + at) % kPhysicalBlock);
        if (happens(0.5)) disk.write(bytes.data() + at, end - at, begin + at);
      }
    }
  }
  return cut;
}

}  // namespace slam::test
