// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <fstream>
#include <string_view>

namespace slam {

/// A file of text that is written row by row, and of which nothing may be lost unnoticed.
class OutputFile {
 public:
  /// @throws std::runtime_error when the file cannot be opened
  explicit OutputFile(const std::filesystem::path& file);
  void write(std::string_view text) { out_ << text; }
  /// @throws std::runtime_error when anything written was lost (disk full)
  void close();

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

}  // namespace slam
