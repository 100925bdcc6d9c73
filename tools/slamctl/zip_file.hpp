// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tools/common/zip_writer.hpp"

namespace slam {

/// A zip file that is written entry by entry. Without close() nothing of it stays.
class ZipFile {
 public:
  /// @param file is never overwritten @throws std::runtime_error with file and reason
  explicit ZipFile(std::filesystem::path file);
  ~ZipFile();
  ZipFile(const ZipFile&) = delete;
  ZipFile& operator=(const ZipFile&) = delete;

  /// @throws std::runtime_error where the disk is full
  void add(const std::string& name, std::string_view content);
  /// The same of another file's content, of any size. @throws also where that cannot be read
  void addFile(const std::string& name, const std::filesystem::path& from);
  /// @throws std::runtime_error where the disk is full
  void close();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path file_;
  std::ofstream out_;
  ZipWriter zip_;
  bool closed_ = false;
};

}  // namespace slam
