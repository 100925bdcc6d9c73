// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slam {

/// Lines of a text file, plain or gzip-compressed.
class TextFile {
 public:
  /// @throws std::runtime_error when it cannot be opened
  explicit TextFile(const std::filesystem::path& file);
  ~TextFile();
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  /// @return false at the end, or where the compressed data is damaged
  /// @throws std::runtime_error where a line has no end, or a small file unpacks to more than anybody recorded
  bool next(std::string& line);
  bool damaged() const { return damaged_; }
  int lineNumber() const { return line_number_; }  ///< of the last line, from 1

 private:
  bool fill();

  std::string name_;
  void* file_;  // gzFile
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // of what is left in it
  std::uint64_t unpacked_ = 0;       // [bytes] and what costs as much
  int line_number_ = 0;
  bool damaged_ = false;
};

/// [bytes] that a file of so many bytes may unpack to: real recordings shrink to a tenth, damage and malice to nothing.
std::uint64_t mostUnpacked(std::uint64_t packed);

/// Words between blanks or commas.
std::vector<std::string_view> splitWords(std::string_view line);

/// @return std::nullopt unless the whole word is a number that is finite
std::optional<double> toNumber(std::string_view word);
/// @return std::nullopt unless all words from `first` on are numbers
std::optional<std::vector<double>> toNumbers(const std::vector<std::string_view>& words, std::size_t first = 0);

/// Seconds written in decimal to microseconds, exactly (a double has too few digits for some epochs).
std::optional<std::int64_t> toMicroseconds(std::string_view seconds);

}  // namespace slam
