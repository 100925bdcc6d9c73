// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/text_file.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <zlib.h>

namespace slam {

TextFile::TextFile(const std::filesystem::path& file) : file_(gzopen(file.c_str(), "rb")) {
  if (file_ == nullptr) throw std::runtime_error(file.string() + ": cannot open: " + std::strerror(errno));
  gzbuffer(static_cast<gzFile>(file_), 1 << 17);
}

TextFile::~TextFile() { gzclose(static_cast<gzFile>(file_)); }

bool TextFile::next(std::string& line) {
  const auto file = static_cast<gzFile>(file_);
  line.clear();
  int c = 0;
  while ((c = gzgetc(file)) >= 0 && c != '\n') line += static_cast<char>(c);  // gzgets would hide bytes behind a zero
  const bool got = c == '\n' || !line.empty();
  while (!line.empty() && line.back() == '\r') line.pop_back();
  int error = Z_OK;
  gzerror(file, &error);
  if (error != Z_OK && error != Z_STREAM_END) damaged_ = true;
  if (got) ++line_number_;
  return got;
}

std::vector<std::string_view> splitWords(std::string_view line) {
  constexpr std::string_view kBlanks = " \t,";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

std::optional<double> toNumber(std::string_view word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> toNumbers(const std::vector<std::string_view>& words, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < words.size(); ++i) {
    const auto number = toNumber(words[i]);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<std::int64_t> toMicroseconds(std::string_view seconds) {
  const auto number = toNumber(seconds);
  constexpr double kLargest = 2.3e9;  // [s] later stamps are refused in messages (fromMessage)
  if (!number || std::abs(*number) > kLargest) return std::nullopt;
  const std::size_t point = seconds.find('.');
  std::int64_t whole = 0;
  const auto [end, error] = std::from_chars(seconds.data(), seconds.data() + std::min(point, seconds.size()), whole);
  if (error != std::errc{} || seconds.find_first_of("eE-") != std::string_view::npos || (point == 0)) {
    return static_cast<std::int64_t>(std::llround(*number * 1e6));
  }
  std::string fraction(point == std::string_view::npos ? "" : seconds.substr(point + 1));
  fraction.resize(7, '0');
  const int digits = std::atoi(fraction.c_str());
  return whole * 1000000 + (digits + 5) / 10;
}

}  // namespace slam
