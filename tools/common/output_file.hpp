// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <fstream>
#include <string_view>

namespace slam {

/// Makes the folders that a file will lie in. Called before the work that the file is for: what cannot be written is
/// refused before hours are lost. Nothing is made or removed where the file is there.
/// @param file empty: nothing is to be written
/// @throws std::runtime_error with file and reason
void prepareOutput(const std::filesystem::path& file);
/// The same for PREFIX.yaml, PREFIX.pgm and PREFIX.png, which are written beside their place and renamed.
void prepareMapFiles(const std::filesystem::path& prefix);

/// A file of text that is written row by row, and of which nothing may be lost unnoticed.
class OutputFile {
 public:
  /// Makes its folders. @throws std::runtime_error when the file cannot be opened
  explicit OutputFile(const std::filesystem::path& file);
  void write(std::string_view text) { out_ << text; }
  /// @throws std::runtime_error when anything written was lost (disk full)
  void close();

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

}  // namespace slam
