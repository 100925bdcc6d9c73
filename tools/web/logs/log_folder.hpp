// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slam {

/// An open file, closed with its last holder.
class OpenFile {
 public:
  OpenFile(int descriptor, std::uint64_t size, std::time_t modified)
      : descriptor_(descriptor), size_(size), modified_(modified) {}
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  std::uint64_t size() const { return size_; }
  std::time_t modified() const { return modified_; }  ///< [s since the epoch]
  /// @return the number of bytes read, fewer at the file's end; 0 also where it cannot be read
  std::size_t read(std::uint64_t offset, char* bytes, std::size_t size) const;

 private:
  int descriptor_;
  std::uint64_t size_;
  std::time_t modified_;
};

/// The folder of field logs, as strangers may see it: what is below it, and no symbolic link, device or pipe.
class LogFolder {
 public:
  static constexpr std::size_t kMostEntries = 2000;
  struct Entry {
    std::string name;
    bool is_folder = false;
    std::uint64_t size = 0;  ///< [bytes]
  };

  explicit LogFolder(std::filesystem::path root) : root_(std::move(root)) {}

  /// @param parts of logPathOf() @return by name, the newest first; std::nullopt where there is no such folder
  std::optional<std::vector<Entry>> list(const std::vector<std::string>& parts) const;
  /// @return nullptr where there is no such regular file
  std::shared_ptr<OpenFile> open(const std::vector<std::string>& parts) const;

 private:
  int openBeneath(const std::vector<std::string>& parts, int flags) const;

  std::filesystem::path root_;
};

}  // namespace slam
