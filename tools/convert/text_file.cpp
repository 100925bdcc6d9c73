// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <zlib.h>

namespace slam {

namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 17;       // [bytes]
constexpr std::uint64_t kLineOverhead = 16;                 // [bytes] that cost as much as a line alone
constexpr std::size_t kLongestLine = std::size_t{1} << 20;  // [bytes] a scan of 4080 beams takes a tenth

}  // namespace

std::uint64_t mostUnpacked(std::uint64_t packed) {
  constexpr std::uint64_t kAnyway = std::uint64_t{64} << 20, kTimes = 200;  // [bytes], of what is packed
  return kAnyway + kTimes * packed;
}

TextFile::TextFile(const std::filesystem::path& file)
    : name_(file.string()), file_(gzopen(file.c_str(), "rb")), buffer_(kBuffer) {
  if (file_ == nullptr) throw std::runtime_error(name_ + ": cannot open: " + std::strerror(errno));
  gzbuffer(static_cast<gzFile>(file_), kBuffer);
}

TextFile::~TextFile() { gzclose(static_cast<gzFile>(file_)); }

bool TextFile::fill() {
  const auto file = static_cast<gzFile>(file_);
  // gzread() forgets what it has unpacked already where damage follows: only what is there is asked for.
  const int first = gzgetc(file);
  const auto more = first < 0 ? 0U : static_cast<unsigned>(std::min<std::size_t>(file->have, buffer_.size() - 1));
  const int got = more == 0 ? 0 : gzread(file, buffer_.data() + 1, more);
  if (first >= 0) buffer_[0] = static_cast<char>(first);
  int error = Z_OK;
  gzerror(file, &error);
  if (error != Z_OK && error != Z_STREAM_END) damaged_ = true;
  begin_ = 0;
  end_ = first < 0 ? 0 : 1 + static_cast<std::size_t>(std::max(0, got));
  unpacked_ += end_;
  if (unpacked_ > mostUnpacked(static_cast<std::uint64_t>(gzoffset(file)))) {
    throw std::runtime_error(name_ + ": unpacks to more than 200 times its size, which no recording does");
  }
  return end_ > 0;
}

bool TextFile::next(std::string& line) {
  line.clear();
  bool ended = false;
  while (!ended && (begin_ < end_ || fill())) {
    const char* const from = buffer_.data() + begin_;
    const void* const at = std::memchr(from, '\n', end_ - begin_);
    const std::size_t size =
        at != nullptr ? static_cast<std::size_t>(static_cast<const char*>(at) - from) : end_ - begin_;
    ended = at != nullptr;
    if (line.size() + size > kLongestLine) {
      throw std::runtime_error(name_ + ":" + std::to_string(line_number_ + 1) +
                               ": this line is longer than 1 MB; it is no text of a recording");
    }
    line.append(from, size);
    begin_ += size + (ended ? 1 : 0);
  }
  const bool got = ended || !line.empty();
  unpacked_ += kLineOverhead;
  while (!line.empty() && line.back() == '\r') line.pop_back();
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
