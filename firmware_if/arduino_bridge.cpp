// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/arduino_bridge.hpp"

#include <algorithm>
#include <charconv>

namespace slam::arduino_bridge {
namespace {

constexpr char kEnd = '\r';

/// @return nullopt unless all of the text is one whole number
std::optional<std::int32_t> numberOf(std::string_view text) {
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

void addText(Outgoing& out, std::string_view text) {
  for (const char c : text) out.addByte(static_cast<std::uint8_t>(c));
}

void addNumber(Outgoing& out, std::int32_t value) {
  std::array<char, 12> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc()) addText(out, {text.data(), static_cast<std::size_t>(end - text.data())});
}

Outgoing letter(char command) { return {static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(kEnd)}; }

}  // namespace

std::optional<Answer> parseLine(std::string_view line) {
  if (line == "OK") return Answer{Answer::kDone};
  if (line == "Invalid Command") return Answer{Answer::kRefused};
  const std::size_t blank = line.find(' ');
  const auto first = numberOf(line.substr(0, blank));
  if (!first) return std::nullopt;
  if (blank == std::string_view::npos) return Answer{Answer::kNumber, {*first, *first}};
  const auto second = numberOf(line.substr(blank + 1));
  return second ? std::optional(Answer{Answer::kCounts, {*first, *second}}) : std::nullopt;
}

std::optional<Answer> LineDecoder::push(std::uint8_t byte) {
  const char c = static_cast<char>(byte);
  if (c != '\r' && c != '\n') {
    too_long_ = too_long_ || size_ == kLongest;
    if (!too_long_) line_[size_++] = c;
    return std::nullopt;
  }
  if (size_ == 0 && !too_long_) return std::nullopt;  // CR LF is one end
  const auto answer = too_long_ ? std::nullopt : parseLine({line_.data(), size_});
  size_ = 0;
  too_long_ = false;
  if (!answer) ++damaged_;
  return answer;
}

Outgoing askCounts() { return letter('e'); }
Outgoing askBaudRate() { return letter('b'); }

Outgoing encodeSpeeds(std::int32_t left, std::int32_t right) {
  Outgoing out;
  addText(out, "m ");
  addNumber(out, std::clamp(left, -kMostCounts, kMostCounts));
  addText(out, " ");
  addNumber(out, std::clamp(right, -kMostCounts, kMostCounts));
  out.addByte(static_cast<std::uint8_t>(kEnd));
  return out;
}

}  // namespace slam::arduino_bridge
